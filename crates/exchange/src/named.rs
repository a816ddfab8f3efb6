//! Axes that a text names: `RAS`, `R A S`, `right-anterior-superior`, and others than are read.

use crate::PatientAxes;

/// Axes that a text names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedAxes {
    /// The letters of the sides that they point to, x first: `RAS`.
    pub letters: String,
    /// Which these are, where they are ones that are read.
    pub axes: Option<PatientAxes>,
}

impl PatientAxes {
    /// From the number that 3D Slicer wrote before it had words, or the word in whatever case, with its letters apart or written out: `ras`,
    /// `R A S`, `Right-Anterior-Superior`. `None` of anything else.
    pub fn of_word(word: &str) -> Option<Self> {
        match word {
            "1" => Some(Self::Lps),
            "0" => Some(Self::Ras),
            word => whole(word)?.axes,
        }
    }
}

/// The sides by their names; letters are the first ones.
const SIDES: [&str; 6] = ["left", "right", "posterior", "anterior", "superior", "inferior"];
/// Letters of one axis each, in the order x, y, z.
const PAIRS: [[char; 2]; 3] = [['L', 'R'], ['P', 'A'], ['S', 'I']];
/// Words behind the names of three axes with blanks between them; any other makes them a part of the body, the right anterior superior
/// iliac spine.
const BEHIND: [&str; 13] = [
    "coordinate",
    "coordinates",
    "axes",
    "axis",
    "frame",
    "space",
    "system",
    "convention",
    "orientation",
    "order",
    "directions",
    "in",
    "mm",
];

/// A word of a text, and where it stands.
#[derive(Clone, Copy)]
struct Word<'a> {
    text: &'a str,
    from: usize,
}

impl Word<'_> {
    fn end(&self) -> usize {
        self.from + self.text.len()
    }
}

/// The axes that are all a text says, in whatever case: three letters together or apart, three names of sides.
pub(crate) fn whole(text: &str) -> Option<NamedAxes> {
    let text = text.trim();
    let words = words(text);
    let covers = |first: &Word<'_>, last: &Word<'_>| first.from == 0 && last.end() == text.len();
    match &words[..] {
        [one] if covers(one, one) => named(&joined(one.text).or_else(|| letters(one.text))?),
        [a, b, c] if covers(a, c) && between(text, *a, *b) == between(text, *b, *c) => named(&apart([*a, *b, *c])?),
        _ => None,
    }
}

/// The axes that a text has the words of, each once: `exported in ras`, `R A S`, `along LAS`, `left-posterior-superior`. Three letters that are
/// neither LPS nor RAS count as capitals alone.
pub(crate) fn named_in(text: &str) -> Vec<NamedAxes> {
    let words = words(text);
    let mut found: Vec<NamedAxes> = Vec::new();
    for (place, word) in words.iter().enumerate() {
        let three: Option<[Word<'_>; 3]> = words.get(place..place + 3).and_then(|three| three.try_into().ok());
        let axes = of_one(word.text).or_else(|| of_three(text, &words, place, three?));
        found.extend(axes.filter(|axes| !found.contains(axes)));
    }
    found
}

/// Those of one word.
fn of_one(word: &str) -> Option<NamedAxes> {
    let one = named(&joined(word).or_else(|| letters(word))?)?;
    let is_plain = one.axes.is_some() || joined(word).is_some() || word.chars().all(|c| c.is_ascii_uppercase());
    is_plain.then_some(one)
}

/// Those of the three words from `place` on, which have the same between them.
fn of_three(text: &str, words: &[Word<'_>], place: usize, three: [Word<'_>; 3]) -> Option<NamedAxes> {
    let [a, b, c] = three;
    let sign = between(text, a, b);
    if sign != between(text, b, c) {
        return None;
    }
    let axes = named(&apart(three)?)?;
    let after = words.get(place + 3).filter(|next| between(text, c, **next) == sign);
    let before = place.checked_sub(1).and_then(|before| words.get(before));
    let before = before.filter(|before| between(text, **before, a) == sign);
    let is_letters = a.text.len() == 1;
    let alone = match is_letters {
        // A word that is spelled, L E F T.
        true => ![after, before]
            .into_iter()
            .flatten()
            .any(|word| word.text.chars().count() == 1),
        false => after.is_none_or(|next| BEHIND.iter().any(|word| next.text.eq_ignore_ascii_case(word))),
    };
    alone.then_some(axes)
}

/// What stands between two words, without blanks.
fn between<'a>(text: &'a str, a: Word<'_>, b: Word<'_>) -> &'a str {
    text.get(a.end()..b.from).unwrap_or_default().trim()
}

fn words(text: &str) -> Vec<Word<'_>> {
    let mut from = 0;
    let words = text.split(|c: char| !c.is_alphanumeric()).map(|piece| {
        let word = Word { text: piece, from };
        // Each piece but the last is ended by one character.
        let rest = text.get(word.end()..).unwrap_or_default();
        from = word.end() + rest.chars().next().map_or(0, char::len_utf8);
        word
    });
    words.filter(|word| !word.text.is_empty()).collect()
}

/// The letters of a word of three.
fn letters(word: &str) -> Option<[char; 3]> {
    let letters: Vec<char> = word.chars().take(4).map(|c| c.to_ascii_uppercase()).collect();
    letters.try_into().ok()
}

/// The letters of names without anything between them.
fn joined(word: &str) -> Option<[char; 3]> {
    let word = word.to_ascii_lowercase();
    let mut rest = word.as_str();
    let mut letters = [' '; 3];
    for letter in &mut letters {
        let side = SIDES.into_iter().find(|side| rest.starts_with(side))?;
        *letter = initial(side);
        rest = rest.get(side.len()..)?;
    }
    rest.is_empty().then_some(letters)
}

/// The letters of three words that are letters, or names, all of them.
fn apart(three: [Word<'_>; 3]) -> Option<[char; 3]> {
    let letter = |word: &Word<'_>| word.text.len() == 1;
    let name = |word: &Word<'_>| SIDES.iter().any(|side| side.eq_ignore_ascii_case(word.text));
    let is_good = three.iter().all(letter) || three.iter().all(name);
    is_good.then(|| three.map(|word| initial(word.text)))
}

fn initial(word: &str) -> char {
    word.chars().next().map_or(' ', |c| c.to_ascii_uppercase())
}

/// The axes of three letters: one of each pair, in the order x, y, z.
fn named(letters: &[char; 3]) -> Option<NamedAxes> {
    let is_axes = letters.iter().zip(PAIRS).all(|(letter, pair)| pair.contains(letter));
    let letters: String = letters.iter().collect();
    let axes = PatientAxes::ALL.into_iter().find(|axes| axes.name() == letters);
    is_axes.then_some(NamedAxes { letters, axes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_found_where_they_are_said_and_not_in_other_words() {
        for (text, letters) in [
            ("exported in ras", &["RAS"][..]),
            ("R A S, then l-p-s", &["RAS", "LPS"]),
            ("right-anterior-superior", &["RAS"]),
            ("Left Posterior Superior coordinates", &["LPS"]),
            ("all in left anterior superior", &["LAS"]),
            ("LeftPosteriorSuperior", &["LPS"]),
            ("along RAI (LPI)", &["RAI", "LPI"]),
            ("RAS RAS ras", &["RAS"]),
            ("right anterior superior iliac spine", &[]),
            ("las, rai and rps; brasil", &[]),
            ("B R A S S", &[]),
            ("R -A S, R A-S", &[]),
            ("superior anterior right, left right left", &[]),
            ("\u{e9}R A S\u{e9} \u{e9} R A S \u{2014}", &[]),
            ("", &[]),
        ] {
            let found: Vec<String> = named_in(text).into_iter().map(|axes| axes.letters).collect();
            assert_eq!(found, letters, "{text:?}");
        }
        assert_eq!(named_in("LAS")[0].axes, None);
        assert_eq!(named_in("lps")[0].axes, Some(PatientAxes::Lps));
    }
    /// `Right-Anterior-Superior` was no word for axes, and what was said of the file was taken.
    #[test]
    fn a_word_of_axes_may_be_of_any_case_and_written_out_and_must_be_whole() {
        for axes in PatientAxes::ALL {
            assert_eq!(PatientAxes::of_word(axes.name()), Some(axes));
        }
        for word in [
            "ras",
            "Ras",
            "R A S",
            "r-a-s",
            "R, A, S",
            "right-anterior-superior",
            "Right Anterior Superior",
            "RIGHT_ANTERIOR_SUPERIOR",
            "RightAnteriorSuperior",
        ] {
            assert_eq!(PatientAxes::of_word(word), Some(PatientAxes::Ras), "{word}");
        }
        assert_eq!(PatientAxes::of_word("Left-Posterior-Superior"), Some(PatientAxes::Lps));
        for word in [
            "",
            "2",
            "IJK",
            "LAS",
            "RAI",
            "SRA",
            "-LPS",
            "LPS-",
            "R -A S",
            "LP",
            "LPSS",
            "L P S x",
            "left posterior",
        ] {
            assert_eq!(PatientAxes::of_word(word), None, "{word}");
        }
    }
}
