//! The documents: every link leads somewhere, every page is in the book, and every test that is named exists.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::floors::{root, rust_files};

/// Pages outside the book whose links are read too.
const OTHERS: [&str; 4] = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "fuzz/README.md"];

fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> = OTHERS.iter().map(|page| root().join(page)).collect();
    for folder in ["docs", "docs/decisions"] {
        let entries = fs::read_dir(root().join(folder)).unwrap().flatten();
        pages.extend(
            entries
                .map(|entry| entry.path())
                .filter(|path| path.extension().is_some_and(|e| e == "md")),
        );
    }
    pages
}

/// The text without blocks of code, in which brackets are no links and `#` no heading.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let mut prose = String::new();
    for line in text.lines() {
        fenced ^= line.starts_with("```");
        if !fenced && !line.starts_with("    ") {
            prose.push_str(line);
            prose.push('\n');
        }
    }
    prose
}

/// The targets of `[words](target)`.
fn links(text: &str) -> Vec<String> {
    let ends = text.match_indices("](").map(|(at, _)| &text[at + 2..]);
    ends.filter_map(|rest| rest.split_once(')'))
        .map(|(target, _)| target.to_owned())
        .collect()
}

/// The anchors of a page's headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |line: &str| -> String {
        let words = line.trim_start_matches('#').trim().to_lowercase();
        let kept = words
            .chars()
            .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

fn broken(page: &Path, target: &str) -> Option<String> {
    if target.contains("://") {
        return None;
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = match file {
        "" => page.to_owned(),
        file => page.parent().unwrap().join(file),
    };
    let fault = |why: &str| {
        Some(format!(
            "{}: {target}: {why}",
            page.strip_prefix(root()).unwrap().display()
        ))
    };
    if !path.exists() {
        return fault("there is no such file");
    }
    let docs = root().join("docs").canonicalize().unwrap();
    if page.starts_with(root().join("docs")) && !path.canonicalize().unwrap().starts_with(docs) {
        return fault("outside the book, where a browser finds nothing: name the file instead");
    }
    let is_page = path.extension().is_some_and(|e| e == "md");
    let has_anchor = || anchors(&prose(&fs::read_to_string(&path).unwrap())).contains(anchor);
    if is_page && !anchor.is_empty() && !has_anchor() {
        return fault("there is no such heading");
    }
    None
}

#[test]
fn every_link_leads_somewhere() {
    let pages = pages();
    assert!(pages.len() > 30, "{}", pages.len());
    let faults: Vec<String> = pages
        .iter()
        .flat_map(|page| {
            let targets = links(&prose(&fs::read_to_string(page).unwrap()));
            targets.into_iter().filter_map(|target| broken(page, &target))
        })
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_link_to_nowhere_is_found() {
    let page = root().join("README.md");
    assert!(broken(&page, "docs/none.md").unwrap().contains("no such file"));
    assert!(
        broken(&page, "docs/faults.md#none")
            .unwrap()
            .contains("no such heading")
    );
    assert_eq!(broken(&page, "docs/faults.md#too-much-to-do"), None);
    assert_eq!(links("see [a](b.md) and [c](d.md#e)."), ["b.md", "d.md#e"]);
}

#[test]
fn every_page_is_in_the_book() {
    let docs = root().join("docs");
    let listed: BTreeSet<PathBuf> = links(&fs::read_to_string(docs.join("SUMMARY.md")).unwrap())
        .into_iter()
        .map(|target| docs.join(target))
        .collect();
    let of_book = pages()
        .into_iter()
        .filter(|page| page.starts_with(&docs) && !page.ends_with("SUMMARY.md"));
    let missing: Vec<_> = of_book.filter(|page| !listed.contains(page)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// Names in backquotes of four words or more are tests: of that many words is no other name in these pages.
#[test]
fn every_test_that_is_named_exists() {
    let mut files = Vec::new();
    rust_files(root(), &mut files);
    let code: String = files.iter().map(|file| fs::read_to_string(file).unwrap()).collect();
    let mut named = 0;
    let mut missing = Vec::new();
    for page in ["ARCHITECTURE.md", "docs/faults.md", "docs/scenes.md"] {
        let text = fs::read_to_string(root().join(page)).unwrap();
        for name in text
            .split('`')
            .skip(1)
            .step_by(2)
            .filter(|name| name.matches('_').count() >= 4)
        {
            if name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
                named += 1;
                if !code.contains(&format!("fn {name}(")) {
                    missing.push(format!("{page}: {name}"));
                }
            }
        }
    }
    assert!(named > 40, "{named}");
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

/// One row of the page for each row of the table in the code, with its payload.
#[test]
fn the_page_of_topics_has_every_topic() {
    let page = fs::read_to_string(root().join("docs/topics.md")).unwrap();
    for topic in bus::topic::TOPICS {
        let row = page
            .lines()
            .find(|line| line.starts_with(&format!("| `{}` |", topic.name)));
        let row = row.unwrap_or_else(|| panic!("{} is not in docs/topics.md", topic.name));
        let payload = topic.payload.split(' ').next().unwrap();
        let words = row.replace('`', "");
        assert!(
            words.contains(payload) && words.contains(topic.purpose),
            "{row}\n{payload} {}",
            topic.purpose
        );
    }
}
