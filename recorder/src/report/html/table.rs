//! Tables of a page.

use std::fmt::Write;

/// A table whose cells are markup already; `None` where it has no rows.
pub(super) fn table(heads: &[&str], rows: &[Vec<String>]) -> Option<String> {
    if rows.is_empty() {
        return None;
    }
    let mut page = String::from("<table>\n<thead><tr>");
    for head in heads {
        let _ = write!(page, "<th scope=\"col\">{head}</th>");
    }
    page.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        page.push_str("<tr>");
        for cell in row {
            let _ = write!(page, "<td>{cell}</td>");
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody>\n</table>\n");
    Some(page)
}

/// A table of names and what they stand for, both markup.
pub(super) fn pairs(rows: &[(&str, String)]) -> String {
    let mut page = String::from("<table class=\"pairs\">\n<tbody>\n");
    for (name, value) in rows {
        let _ = writeln!(page, "<tr><th scope=\"row\">{name}</th><td>{value}</td></tr>");
    }
    page + "</tbody>\n</table>\n"
}

/// A paragraph of markup.
pub(super) fn paragraph(words: &str) -> String {
    format!("<p>{words}</p>\n")
}

/// How many rows are not in a table; nothing where all are.
pub(super) fn more(count: u64, of: &str) -> String {
    match count {
        0 => String::new(),
        _ => paragraph(&format!("{count} more {of} are not listed.")),
    }
}
