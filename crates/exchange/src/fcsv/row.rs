//! A line of columns, as Slicer's own reader and writer have them.

/// The columns of a line; `None` where a quote is not ended. A quotation mark in the middle of a column stands for
/// itself.
pub(super) fn columns(line: &str) -> Option<Vec<String>> {
    let mut columns = vec![String::new()];
    let mut quoted = false;
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        let is_first = columns.last().is_some_and(String::is_empty);
        match (quoted, letter) {
            (true, '"') if letters.next_if_eq(&'"').is_some() => push(&mut columns, '"'),
            (true, '"') => quoted = false,
            (false, '"') if is_first => quoted = true,
            (false, ',') => columns.push(String::new()),
            (_, other) => push(&mut columns, other),
        }
    }
    (!quoted).then_some(columns)
}

fn push(columns: &mut [String], letter: char) {
    if let Some(last) = columns.last_mut() {
        last.push(letter);
    }
}

/// A column that [`columns()`] reads back.
pub(super) fn column(text: &str) -> String {
    match text.contains(['"', ',']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_hold_commas_and_quotes() {
        let read = |line: &str| columns(line);
        assert_eq!(read("a,\"b, \"\"c\"\"\",,d\"e").unwrap(), ["a", "b, \"c\"", "", "d\"e"]);
        assert_eq!(read("\"\",x").unwrap(), ["", "x"]);
        assert_eq!(read("a,\"b"), None);
        for text in ["", "a", "a,b", "\"", "\"\"", "a\"b", ",", "\"a\",\"b\""] {
            let line = format!("{},{}", column(text), column(text));
            assert_eq!(read(&line).unwrap(), [text, text], "{line}");
        }
    }
}
