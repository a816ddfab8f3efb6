//! Texts of a file on a page: whatever they hold, they are read as text.

/// A text between tags or in an attribute. Markup is escaped; what a reader does not see, or what turns the order of letters around,
/// is shown by its number; the rest stands as it is, in whatever script.
pub(super) fn text(text: &str) -> String {
    let mut page = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => page.push_str("&amp;"),
            '<' => page.push_str("&lt;"),
            '>' => page.push_str("&gt;"),
            '"' => page.push_str("&quot;"),
            '\'' => page.push_str("&#39;"),
            '\n' | '\t' => page.push(' '),
            _ if is_unseen(letter) => page.push_str(&format!("[U+{:04X}]", u32::from(letter))),
            _ => page.push(letter),
        }
    }
    page
}

/// A text of the file between tags, whose direction does not reach beyond it.
pub(super) fn own(text: &str) -> String {
    format!("<bdi>{}</bdi>", self::text(text))
}

/// Control characters, among them those that XML forbids; marks of direction; letters without width or form. Joiners stay: scripts
/// need them.
fn is_unseen(letter: char) -> bool {
    letter.is_control()
        || matches!(letter,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff0}'..='\u{fffb}' | '\u{fffe}'..='\u{ffff}'
            | '\u{e0000}'..='\u{e0fff}')
        || u32::from(letter) & 0xfffe == 0xfffe
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn markup_and_what_is_not_seen_are_shown() {
        assert_eq!(
            text("<script>a('&\")</script>"),
            "&lt;script&gt;a(&#39;&amp;&quot;)&lt;/script&gt;"
        );
        assert_eq!(text("a\u{202e}b\0c\u{1b}[31m"), "a[U+202E]b[U+0000]c[U+001B][31m");
        assert_eq!(
            text("Müller 山田 עברית a\u{200d}b\nc"),
            "Müller 山田 עברית a\u{200d}b c"
        );
        assert_eq!(text("\u{1ffff}\u{fffe}"), "[U+1FFFF][U+FFFE]");
    }

    proptest! {
        #[test]
        fn no_text_holds_markup_or_what_xml_forbids(letters in prop::collection::vec(any::<char>(), 0..200)) {
            let page = text(&letters.into_iter().collect::<String>());
            let is_bad = |c: char| matches!(c, '<' | '>' | '"' | '\'') || c < ' ' || ('\u{7f}'..'\u{a0}').contains(&c);
            prop_assert!(!page.chars().any(is_bad), "{}", page);
        }
    }
}
