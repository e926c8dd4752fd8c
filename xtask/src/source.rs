//! Rust source files as tokens.

use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};

use crate::Trouble;

/// All files below `folder` whose name ends in `.extension`, sorted.
pub(crate) fn files_below(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, Trouble> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).map_err(|error| Trouble::reading(&folder, &error))?;
        for entry in entries {
            let path = entry
                .map_err(|error| Trouble::reading(&folder, &error))?
                .path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The text of a file.
pub(crate) fn read(path: &Path) -> Result<String, Trouble> {
    fs::read_to_string(path).map_err(|error| Trouble::reading(path, &error))
}

/// The tokens of Rust source: comments and the insides of strings are not among them.
pub(crate) fn tokens(source: &str, path: &Path) -> Result<Vec<TokenTree>, Trouble> {
    let stream: TokenStream = source
        .parse()
        .map_err(|error| Trouble(format!("{}: {error}", path.display())))?;
    Ok(stream.into_iter().collect())
}

/// The text of an identifier.
pub(crate) fn identifier(token: Option<&TokenTree>) -> Option<String> {
    match token {
        Some(TokenTree::Ident(identifier)) => Some(identifier.to_string()),
        _ => None,
    }
}

/// Whether `tokens` begin with `::`.
pub(crate) fn begins_with_path_separator(tokens: &[TokenTree]) -> bool {
    let colon = |token: Option<&TokenTree>| matches!(token, Some(TokenTree::Punct(p)) if p.as_char() == ':');
    colon(tokens.first()) && colon(tokens.get(1))
}

/// The module path of a file below `src`: `mesh/repair/weld.rs` is `["mesh", "repair", "weld"]`.
pub(crate) fn module_path(file: &Path, src: &Path) -> Vec<String> {
    let relative = file.strip_prefix(src).unwrap_or(file).with_extension("");
    let mut path: Vec<String> = relative
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    if path
        .last()
        .is_some_and(|last| last == "mod" || last == "lib")
    {
        path.pop();
    }
    path
}
