//! The contact sheet: the pictures of all runs on one page.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::table::Table;
use crate::Trouble;

/// The name of the picture of a run on a file.
pub(super) fn picture_name(file: &str, run: &str) -> String {
    format!("{}-{run}.png", file.replace(['/', '.'], "-"))
}

/// Writes the sheet: a row for each file that has a picture. Pictures are beside it in `pictures/`.
pub(super) fn write(folder: &Path, table: &Table) -> Result<(), Trouble> {
    let mut page = String::from(
        "<!doctype html><meta charset=\"utf-8\"><title>Corpus</title>\n\
         <style>img{width:24rem}figure{display:inline-block;margin:.3rem}</style>\n",
    );
    for row in &table.rows {
        let pictures = row.cells.iter().filter_map(|cell| {
            let name = picture_name(&row.file, cell.run);
            let is_there = folder.join("pictures").join(&name).is_file();
            is_there.then_some((cell, name))
        });
        for (number, (cell, name)) in pictures.enumerate() {
            if number == 0 {
                let _ = writeln!(page, "<h2>{}</h2>", row.file);
            }
            let _ = writeln!(
                page,
                "<figure><img src=\"pictures/{name}\" alt=\"\" loading=\"lazy\">\
                 <figcaption>{}: {}, {:.1} s</figcaption></figure>",
                cell.run, cell.verdict, cell.seconds,
            );
        }
    }
    let sheet = folder.join("sheet.html");
    fs::write(&sheet, page).map_err(|error| Trouble::reading(&sheet, &error))
}
