//! How reports are written.

/// Adds a line of formatted words to a `String`; an empty one where none are given.
macro_rules! line {
    ($text:expr) => { $text.push('\n') };
    ($text:expr, $($arguments:tt)*) => {{
        $text.push_str(&format!($($arguments)*));
        $text.push('\n');
    }};
}
pub(crate) use line;

/// A length in mm, or another number, with the digits that matter.
pub(crate) fn mm(x: f64) -> String {
    if x == 0.0 || (1e-2..1e6).contains(&x.abs()) {
        return format!("{x:.4}");
    }
    format!("{x:.3e}")
}

/// Text from outside without what would move the cursor or colour the terminal.
pub(crate) fn shown(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}
