//! Checks that each module of the library uses only modules that stand above it in the table of
//! `lib.rs`, and that the crates around the library stay leaves.

use std::collections::BTreeMap;
use std::path::Path;

use proc_macro2::{Delimiter, TokenTree};

use crate::Trouble;
use crate::source::{
    begins_with_path_separator, files_below, identifier, module_path, read, tokens,
};

/// Modules that every layer may use, and that use none of them.
const COMMON_GROUND: [&str; 4] = ["hint", "papers", "tolerance", "watch"];

/// Which crates of the workspace each crate may depend on.
const CRATES: [(&str, &[&str]); 6] = [
    ("graticule", &["graticule-fixtures"]),
    ("graticule-fixtures", &[]),
    ("graticule-io", &["graticule", "graticule-fixtures"]),
    ("graticule-draw", &["graticule", "graticule-fixtures"]),
    (
        "graticule-cli",
        &[
            "graticule",
            "graticule-io",
            "graticule-draw",
            "graticule-fixtures",
        ],
    ),
    (
        "xtask",
        &["graticule", "graticule-io", "graticule-fixtures"],
    ),
];

/// A use of one module of the crate by another.
#[derive(Debug, PartialEq, Eq)]
struct Use {
    module: String,
    line: usize,
}

/// Runs both checks on the workspace at `root` and returns what was checked, in a sentence.
pub(crate) fn check(root: &Path) -> Result<String, Trouble> {
    let mut faults = module_faults(root)?;
    faults.extend(crate_faults(root)?);
    if faults.is_empty() {
        Ok("layers: every module uses only what stands above it".into())
    } else {
        Err(Trouble(faults.join("\n")))
    }
}

fn module_faults(root: &Path) -> Result<Vec<String>, Trouble> {
    let src = root.join("crates/graticule/src");
    let lib = read(&src.join("lib.rs"))?;
    let ranks = layer_ranks(&lib);
    let mut faults = undeclared_layers(&lib, &ranks, &src)?;
    for file in files_below(&src, "rs")? {
        let path = module_path(&file, &src);
        let Some(user) = path.first() else { continue };
        let tokens = tokens(&read(&file)?, &file)?;
        for used in uses(&tokens, path.len()) {
            if let Some(reason) = forbidden(user, &used.module, &ranks) {
                let place = file.strip_prefix(root).unwrap_or(&file).display();
                faults.push(format!("{place}:{}: {reason}", used.line));
            }
        }
    }
    Ok(faults)
}

/// The rank of each layer: its row in the table of `lib.rs`, from the top.
fn layer_ranks(lib: &str) -> BTreeMap<String, usize> {
    let rows = lib.lines().filter_map(|line| {
        let cell = line.strip_prefix("//! | [`")?;
        Some(cell.split_once("`]")?.0.to_owned())
    });
    rows.enumerate().map(|(rank, name)| (name, rank)).collect()
}

/// Modules that `lib.rs` declares but neither its table nor the common ground names.
fn undeclared_layers(
    lib: &str,
    ranks: &BTreeMap<String, usize>,
    src: &Path,
) -> Result<Vec<String>, Trouble> {
    let tokens = tokens(lib, &src.join("lib.rs"))?;
    let declared = tokens.windows(2).filter_map(|pair| {
        (identifier(pair.first())? == "mod").then(|| identifier(pair.get(1)))?
    });
    Ok(declared
        .filter(|name| !ranks.contains_key(name) && !COMMON_GROUND.contains(&name.as_str()))
        .map(|name| format!("lib.rs: module `{name}` is missing in the table of layers"))
        .collect())
}

/// Why `user` may not use `used`, if it may not. Names that are no layers (re-exports of the
/// common ground, macros) are everyone's.
fn forbidden(user: &str, used: &str, ranks: &BTreeMap<String, usize>) -> Option<String> {
    let used_rank = *ranks.get(used)?;
    match ranks.get(user) {
        None if COMMON_GROUND.contains(&user) => Some(format!(
            "`{user}` is common ground and may not use `{used}`"
        )),
        Some(&user_rank) if used_rank > user_rank => Some(format!(
            "`{user}` may not use `{used}`, which stands below it"
        )),
        _ => None,
    }
}

/// All uses of modules at the root of the crate, by `crate::…` or by enough `super::`s, in a file
/// whose module lies `depth` below the root. Macros' arguments are searched too.
fn uses(tokens: &[TokenTree], depth: usize) -> Vec<Use> {
    let mut found = Vec::new();
    collect_uses(tokens, depth, &mut found);
    found
}

fn collect_uses(tokens: &[TokenTree], depth: usize, found: &mut Vec<Use>) {
    for (index, token) in tokens.iter().enumerate() {
        match token {
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                let depth = depth + usize::from(is_inline_module(tokens, index));
                collect_uses(&inner, depth, found);
            }
            TokenTree::Ident(name) if name == "crate" => {
                collect_roots(&tokens[index + 1..], found);
            }
            TokenTree::Ident(name) if name == "super" && !follows_super(tokens, index) => {
                let (climbed, rest) = climb(&tokens[index..]);
                if climbed == depth {
                    collect_roots(rest, found);
                }
            }
            _ => {}
        }
    }
}

/// Whether the group at `index` is the body of `mod name { … }`.
fn is_inline_module(tokens: &[TokenTree], index: usize) -> bool {
    index >= 2 && identifier(tokens.get(index - 2)).is_some_and(|word| word == "mod")
}

fn follows_super(tokens: &[TokenTree], index: usize) -> bool {
    index >= 3 && identifier(tokens.get(index - 3)).is_some_and(|word| word == "super")
}

/// The number of leading `super::`s and what follows the last `super`.
fn climb(mut tokens: &[TokenTree]) -> (usize, &[TokenTree]) {
    let mut count = 0;
    while identifier(tokens.first()).is_some_and(|word| word == "super") {
        count += 1;
        tokens = &tokens[1..];
        if begins_with_path_separator(tokens)
            && identifier(tokens.get(2)).is_some_and(|word| word == "super")
        {
            tokens = &tokens[2..];
        }
    }
    (count, tokens)
}

/// The first names of the path, or of the braced paths, that follow `::` at the crate's root.
fn collect_roots(tokens: &[TokenTree], found: &mut Vec<Use>) {
    if !begins_with_path_separator(tokens) {
        return;
    }
    match tokens.get(2) {
        Some(TokenTree::Ident(name)) => found.push(Use {
            module: name.to_string(),
            line: name.span().start().line,
        }),
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
            let inner: Vec<TokenTree> = group.stream().into_iter().collect();
            let is_comma =
                |token: &TokenTree| matches!(token, TokenTree::Punct(p) if p.as_char() == ',');
            for branch in inner.split(is_comma) {
                if let Some(TokenTree::Ident(name)) = branch.first() {
                    let line = name.span().start().line;
                    found.push(Use {
                        module: name.to_string(),
                        line,
                    });
                }
            }
        }
        _ => {}
    }
}

/// Dependencies between crates of the workspace that the table [`CRATES`] does not allow.
fn crate_faults(root: &Path) -> Result<Vec<String>, Trouble> {
    let mut faults = Vec::new();
    for manifest in crate_manifests(root)? {
        let text = read(&manifest)?;
        let Some(name) = package_name(&text) else {
            continue;
        };
        let Some((_, allowed)) = CRATES.iter().find(|(known, _)| *known == name) else {
            faults.push(format!(
                "crate `{name}` is missing in xtask's table of crates"
            ));
            continue;
        };
        let excess = workspace_dependencies(&text).filter(|used| !allowed.contains(used));
        faults.extend(excess.map(|used| format!("crate `{name}` may not depend on `{used}`")));
    }
    Ok(faults)
}

fn crate_manifests(root: &Path) -> Result<Vec<std::path::PathBuf>, Trouble> {
    let mut manifests = files_below(&root.join("crates"), "toml")?;
    manifests.retain(|path| path.ends_with("Cargo.toml"));
    manifests.push(root.join("xtask/Cargo.toml"));
    Ok(manifests)
}

fn package_name(manifest: &str) -> Option<&str> {
    let line = manifest.lines().find(|line| line.starts_with("name = "))?;
    line.split('"').nth(1)
}

/// Dependencies of a manifest that are crates of this workspace, by their names.
fn workspace_dependencies(manifest: &str) -> impl Iterator<Item = &str> {
    manifest.lines().filter_map(|line| {
        let name = line.split(['.', ' ', '=']).next()?;
        let is_dependency = line.contains("workspace = true");
        (is_dependency && CRATES.iter().any(|(known, _)| *known == name)).then_some(name)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn modules(source: &str, depth: usize) -> Vec<String> {
        let tokens = tokens(source, Path::new("test.rs")).unwrap();
        uses(&tokens, depth).into_iter().map(|u| u.module).collect()
    }

    #[test]
    fn every_form_of_path_is_found() {
        assert_eq!(modules("use crate::mesh::Surface;", 1), ["mesh"]);
        assert_eq!(
            modules("use crate::{mesh::Surface, solve::{self, Lu}, Hint};", 1),
            ["mesh", "solve", "Hint"]
        );
        assert_eq!(
            modules("fn f() -> crate::solve::Lu { g!(crate::charts::X) }", 1),
            ["solve", "charts"]
        );
        assert_eq!(modules("pub(crate) fn f() {}", 1), [""; 0]);
    }

    #[test]
    fn super_counts_where_it_reaches_the_root() {
        assert_eq!(modules("use super::mesh;", 1), ["mesh"]);
        assert_eq!(modules("use super::patch;", 2), [""; 0]);
        assert_eq!(modules("use super::super::solve;", 2), ["solve"]);
        assert_eq!(
            modules("mod tests { use super::*; use super::super::solve; }", 1),
            ["solve"]
        );
    }

    #[test]
    fn comments_and_strings_do_not_count() {
        assert_eq!(
            modules(
                "/// [`crate::charts`]\nconst A: &str = \"crate::quads\";",
                1
            ),
            [""; 0]
        );
    }

    #[test]
    fn using_a_lower_layer_is_forbidden_and_a_higher_one_is_not() {
        let ranks = layer_ranks("//! | [`mesh`] | a |\n//! | [`solve`] | b |\n");
        assert!(forbidden("mesh", "solve", &ranks).is_some());
        assert!(forbidden("watch", "mesh", &ranks).is_some());
        assert_eq!(forbidden("solve", "mesh", &ranks), None);
        assert_eq!(forbidden("solve", "solve", &ranks), None);
        assert_eq!(forbidden("mesh", "watch", &ranks), None);
    }

    #[test]
    fn dependencies_on_crates_of_the_workspace_are_found() {
        let manifest = "[package]\nname = \"x\"\n[dependencies]\nfaer.workspace = true\n\
            graticule.workspace = true\ngraticule-io = { workspace = true }\n";
        let found: Vec<_> = workspace_dependencies(manifest).collect();
        assert_eq!(found, ["graticule", "graticule-io"]);
    }
}
