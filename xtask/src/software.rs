//! The software of others that the programs are built of: what IEC 62304 calls SOUP.

use std::collections::BTreeMap;

use crate::failure::Failure;
use crate::shell::{cargo, said};

/// A page with each package, its version, its licence and where it is from.
///
/// # Errors
/// [`Failure::Start`], [`Failure::Ended`].
pub(crate) fn list() -> Result<String, Failure> {
    let format = "{p}|{l}|{r}";
    let mut tree = cargo(&[
        "tree",
        "--package",
        "trocar",
        "--edges",
        "normal",
        "--prefix",
        "none",
        "--format",
        format,
    ]);
    Ok(page(&said(&mut tree)?))
}

fn page(tree: &str) -> String {
    let mut packages = BTreeMap::new();
    // Packages of the project itself are named with their folder, those of others by name and version alone.
    for line in tree.lines().filter(|line| !line.contains(" (/")) {
        let mut fields = line.trim_end_matches(" (*)").split('|');
        let (name, licence, source) = (fields.next(), fields.next(), fields.next());
        let words: Vec<&str> = name.unwrap_or_default().split_whitespace().collect();
        if let [name, version, ..] = words[..] {
            packages.insert((name, version), (licence.unwrap_or(""), source.unwrap_or("")));
        }
    }
    let mut page =
        "# Software of others\n\nEvery package that the programs are built of, from crates.io. `Cargo.lock` has the \
                    checksums.\n\n| package | version | licence | source |\n|---|---|---|---|\n"
            .to_owned();
    for ((name, version), (licence, source)) in packages {
        page.push_str(&format!(
            "| {name} | {} | {licence} | {source} |\n",
            version.trim_start_matches('v')
        ));
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_package_of_others_is_listed_once() {
        let tree = "trocar v0.1.0 (/home/x/trocar)|MIT|\nserde v1.0.1|MIT OR Apache-2.0|https://a\nserde v1.0.1|MIT OR Apache-2.0|https://a (*)\n";
        let page = page(tree);
        assert_eq!(
            page.matches("| serde | 1.0.1 | MIT OR Apache-2.0 | https://a |")
                .count(),
            1
        );
        assert!(!page.contains("trocar v"));
    }
}
