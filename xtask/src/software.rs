//! The software of others that the programs are built of (what IEC 62304 calls SOUP), and its licences.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::shell::{cargo, said};

/// How files with the words of a licence are named.
const LICENCES: [&str; 6] = ["license", "licence", "copying", "notice", "copyright", "unlicense"];

/// Writes `SOFTWARE.md`, a page with each package, its version, its licence and where it is from, and the words of the licences,
/// below `folder`.
///
/// # Errors
/// [`Failure::Start`], [`Failure::Ended`], [`Failure::File`].
pub(crate) fn write(folder: &Path) -> Result<(), Failure> {
    let format = "{p}|{l}|{r}";
    let tree = [
        "tree",
        "--package",
        "trocar",
        "--edges",
        "normal",
        "--prefix",
        "none",
        "--format",
        format,
    ];
    let tree = said(&mut cargo(&tree))?;
    let packages = packages(&tree);
    let page_path = folder.join("SOFTWARE.md");
    fs::write(&page_path, page(&packages)).map_err(|e| Failure::file(&page_path, e))?;
    let sources = sources()?;
    for (name, version) in packages.keys() {
        let name = format!("{name}-{version}");
        let found = sources
            .iter()
            .map(|source| source.join(&name))
            .find(|path| path.is_dir());
        if let Some(found) = found {
            licences(&found, &folder.join("licences").join(&name))?;
        }
    }
    Ok(())
}

/// Where Cargo keeps the sources of packages, by the manifests that it names.
fn sources() -> Result<Vec<PathBuf>, Failure> {
    let metadata = said(&mut cargo(&["metadata", "--format-version", "1"]))?;
    let manifests = metadata
        .split("\"manifest_path\":\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next());
    let mut folders: Vec<PathBuf> = manifests
        .filter(|path| path.contains("/registry/src/"))
        .filter_map(|path| Some(Path::new(path).parent()?.parent()?.to_owned()))
        .collect();
    folders.sort();
    folders.dedup();
    Ok(folders)
}

/// Copies what names itself a licence; beside fonts, these are text files of the font's name.
fn licences(from: &Path, to: &Path) -> Result<(), Failure> {
    for (folder, is_font) in [(from.to_owned(), false), (from.join("fonts"), true)] {
        let Ok(entries) = fs::read_dir(&folder) else { continue };
        for path in entries
            .flatten()
            .map(|entry| entry.path())
            .filter(|path| path.is_file())
        {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let lower = name.to_lowercase();
            let is_licence = LICENCES.iter().any(|word| lower.starts_with(word));
            if is_licence || is_font && lower.ends_with(".txt") {
                fs::create_dir_all(to).map_err(|e| Failure::file(to, e))?;
                fs::copy(&path, to.join(&name)).map_err(|e| Failure::file(&path, e))?;
            }
        }
    }
    Ok(())
}

/// Licence and source of each package of others, by name and version.
fn packages(tree: &str) -> BTreeMap<(&str, &str), (&str, &str)> {
    let mut packages = BTreeMap::new();
    // Packages of the project itself are named with their folder, those of others by name and version alone.
    for line in tree.lines().filter(|line| !line.contains(" (/")) {
        let mut fields = line.trim_end_matches(" (*)").split('|');
        let (name, licence, source) = (fields.next(), fields.next(), fields.next());
        let words: Vec<&str> = name.unwrap_or_default().split_whitespace().collect();
        if let [name, version, ..] = words[..] {
            let version = version.trim_start_matches('v');
            packages.insert((name, version), (licence.unwrap_or(""), source.unwrap_or("")));
        }
    }
    packages
}

fn page(packages: &BTreeMap<(&str, &str), (&str, &str)>) -> String {
    let mut page = "# Software of others\n\nEvery package that the programs are built of, from crates.io. `Cargo.lock` has the \
                    checksums, `licences/` the words of the licences.\n\n| package | version | licence | source |\n|---|---|---|---|\n"
        .to_owned();
    for ((name, version), (licence, source)) in packages {
        page.push_str(&format!("| {name} | {version} | {licence} | {source} |\n"));
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_package_of_others_is_listed_once() {
        let tree = "trocar v0.1.0 (/home/x/trocar)|MIT|\nserde v1.0.1|MIT OR Apache-2.0|https://a\nserde v1.0.1|MIT OR Apache-2.0|https://a (*)\n";
        let page = page(&packages(tree));
        assert_eq!(
            page.matches("| serde | 1.0.1 | MIT OR Apache-2.0 | https://a |")
                .count(),
            1
        );
        assert!(!page.contains("trocar v"));
    }
}
