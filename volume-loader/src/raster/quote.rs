//! Text of a header: as an error may repeat it, and its numbers.

/// The most of a file's text that an error repeats, characters.
const MAX_QUOTE: usize = 80;
/// A file's text as an error may repeat it: its beginning.
pub(crate) fn quote(text: &str) -> String {
    let mut short: String = text.chars().take(MAX_QUOTE).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}

/// Exactly `N` numbers between spaces; `None` where there are more, fewer or other words.
pub(crate) fn numbers<T: std::str::FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    // No honest list is longer; a hostile one is not collected.
    let words: Vec<T> = text
        .split_whitespace()
        .take(N + 1)
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    words.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_exactly_as_many() {
        assert_eq!(numbers::<f64, 3>(" 1 -2.5e1  3 "), Some([1.0, -25.0, 3.0]));
        assert_eq!(numbers::<f64, 3>("1 2"), None);
        assert_eq!(numbers::<f64, 3>("1 2 3 4"), None);
        assert_eq!(numbers::<i64, 1>("1.0"), None);
    }

    #[test]
    fn quotes_are_short() {
        assert_eq!(quote("short"), "short");
        assert_eq!(quote(&"é".repeat(500)).chars().count(), 83);
    }
}
