//! A line cut into fields, and fields read as numbers. Columns are characters counted from 1, as editors show them.

use std::borrow::Cow;

/// The largest coordinate, mm: a thousand kilometres, beyond which a file cannot be in millimetres.
pub(crate) const MAX_MM: f64 = 1e9;

/// One field: its text without quotes and surrounding blanks, and the column where that begins.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Field<'a> {
    pub(crate) text: Cow<'a, str>,
    pub(crate) column: usize,
}

/// What is wrong with a field that should be a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BadNumber {
    NotANumber,
    NotFinite,
    TooLarge,
    Negative,
}

/// A quote was opened in this column and not closed, or text follows it.
#[derive(Debug, PartialEq)]
pub(crate) struct BadQuote(pub(crate) usize);

/// The fields of a line of comma-separated values; quotes as in RFC 4180, within one line.
pub(crate) fn csv(line: &str) -> Result<Vec<Field<'_>>, BadQuote> {
    let mut fields = Vec::new();
    let mut start = 0;
    loop {
        let (field, end) = field(line, start)?;
        fields.push(field);
        match end {
            Some(comma) => start = comma + 1,
            None => return Ok(fields),
        }
    }
}

/// The field that begins at byte `start`, and where the comma after it is.
fn field(line: &str, start: usize) -> Result<(Field<'_>, Option<usize>), BadQuote> {
    let rest = &line[start..];
    let blanks = rest.len() - rest.trim_start().len();
    let column = column(line, start + blanks);
    if let Some(quoted) = rest[blanks..].strip_prefix('"') {
        let (text, length) = unquoted(quoted).ok_or(BadQuote(column))?;
        let after = start + blanks + 1 + length;
        let end = line[after..].find(',').map(|i| after + i);
        let left_over = &line[after..end.unwrap_or(line.len())];
        if !left_over.trim().is_empty() {
            return Err(BadQuote(column));
        }
        let text = Cow::Owned(text);
        return Ok((Field { text, column }, end));
    }
    let end = rest.find(',').map(|i| start + i);
    let text = Cow::Borrowed(line[start..end.unwrap_or(line.len())].trim());
    Ok((Field { text, column }, end))
}

/// The text up to the closing quote with doubled quotes made single, and the bytes it took with that quote.
fn unquoted(quoted: &str) -> Option<(String, usize)> {
    let mut text = String::new();
    let mut characters = quoted.char_indices().peekable();
    while let Some((at, c)) = characters.next() {
        if c != '"' {
            text.push(c);
        } else if characters.next_if(|(_, next)| *next == '"').is_some() {
            text.push('"');
        } else {
            return Some((text, at + 1));
        }
    }
    None
}

/// The numbers of a line, with commas or with blanks between them.
pub(crate) fn plain(line: &str) -> Vec<Field<'_>> {
    let separated = line.contains(',');
    let part = |piece: &'_ str| -> usize { piece.as_ptr() as usize - line.as_ptr() as usize };
    let pieces: Vec<&str> = match separated {
        true => line.split(',').map(str::trim).collect(),
        false => line.split_whitespace().collect(),
    };
    let pieces = pieces.into_iter().map(|piece| Field {
        text: Cow::Borrowed(piece),
        column: column(line, part(piece)),
    });
    pieces.collect()
}

fn column(line: &str, byte: usize) -> usize {
    line[..byte].chars().count() + 1
}

/// A coordinate in mm.
pub(crate) fn coordinate(text: &str) -> Result<f64, BadNumber> {
    let value = finite(text)?;
    if value.abs() > MAX_MM {
        return Err(BadNumber::TooLarge);
    }
    Ok(value)
}

/// A weight of at least 0.
pub(crate) fn weight(text: &str) -> Result<f64, BadNumber> {
    let value = finite(text)?;
    if value < 0.0 {
        return Err(BadNumber::Negative);
    }
    Ok(value)
}

fn finite(text: &str) -> Result<f64, BadNumber> {
    let value: f64 = text.parse().map_err(|_| BadNumber::NotANumber)?;
    if value.is_finite() {
        return Ok(value);
    }
    Err(BadNumber::NotFinite)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn texts<'a>(fields: &'a [Field<'_>]) -> Vec<(&'a str, usize)> {
        fields.iter().map(|f| (f.text.as_ref(), f.column)).collect()
    }

    #[test]
    fn fields_know_their_columns() {
        let fields = csv("1, 2.5 ,\"a, \"\"b\"\"\" ,é,x").unwrap();
        assert_eq!(
            texts(&fields),
            [("1", 1), ("2.5", 4), ("a, \"b\"", 9), ("é", 21), ("x", 23)]
        );
        assert_eq!(texts(&csv("1,,").unwrap()), [("1", 1), ("", 3), ("", 4)]);
        assert_eq!(texts(&plain("  1\t-2  3e4 ")), [("1", 3), ("-2", 5), ("3e4", 9)]);
        assert_eq!(texts(&plain("1, 2,3 4")), [("1", 1), ("2", 4), ("3 4", 6)]);
    }

    #[test]
    fn quotes_must_close_and_end_the_field() {
        assert_eq!(csv("1,\"open"), Err(BadQuote(3)));
        assert_eq!(csv("\"a\"b,1"), Err(BadQuote(1)));
    }

    #[test]
    fn numbers() {
        assert_eq!(coordinate("-1.5e2"), Ok(-150.0));
        for (text, reason) in [
            ("", BadNumber::NotANumber),
            ("1,5", BadNumber::NotANumber),
            ("0x10", BadNumber::NotANumber),
            ("NaN", BadNumber::NotFinite),
            ("-inf", BadNumber::NotFinite),
            ("1e999", BadNumber::NotFinite),
            ("2e9", BadNumber::TooLarge),
        ] {
            assert_eq!(coordinate(text), Err(reason), "{text}");
        }
        assert_eq!(weight("-1"), Err(BadNumber::Negative));
        assert_eq!(weight("1e300"), Ok(1e300));
    }

    proptest! {
        #[test]
        fn no_line_panics(line in "[ \t,\"a1é#\u{2028}\u{1F600}-]{0,40}") {
            let _ = csv(&line);
            let _ = plain(&line);
        }

        #[test]
        fn what_is_quoted_comes_back(text in "[a-z,\" é]{0,20}") {
            let line = format!("1,\"{}\",2", text.replace('"', "\"\""));
            let fields = csv(&line).unwrap();
            prop_assert_eq!(fields.len(), 3);
            prop_assert_eq!(fields[1].text.as_ref(), text.as_str());
        }
    }
}
