//! A surface as a file has it, before its frame and unit are settled.

use super::{MAX_COUNT, MeshError};
use crate::named::named_in;
use crate::units::{About, about, unit_of, units_in};
use crate::{LengthUnit, NamedAxes, NamedUnit, PatientAxes};

/// Points in the file's own numbers, triangles that nobody has checked, and the axes and the unit that its comments say.
#[derive(Debug, Default)]
pub(super) struct Raw {
    pub(super) points: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) axes: Option<PatientAxes>,
    /// Axes that are named in comments, also otherwise than as `SPACE=`.
    pub(super) named: Vec<NamedAxes>,
    pub(super) unit: Option<LengthUnit>,
    /// Units that are named in comments.
    pub(super) units: Vec<NamedUnit>,
}

impl Raw {
    /// A polygon as a fan of triangles.
    pub(super) fn polygon(&mut self, place: usize, corners: &[u32]) -> Result<(), MeshError> {
        let [first, rest @ ..] = corners else {
            return Err(MeshError::Polygon { place, corners: 0 });
        };
        if rest.len() < 2 {
            return Err(MeshError::Polygon {
                place,
                corners: corners.len(),
            });
        }
        self.triangles
            .extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        counted("triangles", self.triangles.len() as u64).map(|_| ())
    }

    /// Takes what a comment says of axes, as 3D Slicer writes them, and of the unit; what is not understood, and two words that differ, are
    /// refused.
    pub(super) fn comment(&mut self, comment: &str) -> Result<(), MeshError> {
        for value in assigned(comment, "space", &[]) {
            let found = || MeshError::Space {
                found: crate::quoted(value),
            };
            let axes: PatientAxes = first_word(value).parse().map_err(|_| found())?;
            if self.axes.replace(axes).is_some_and(|before| before != axes) {
                return Err(found());
            }
        }
        let mut is_numbered = false;
        for value in assigned(comment, "unit", VERBS).chain(assigned(comment, "units", VERBS)) {
            let found = || MeshError::Unit {
                found: crate::quoted(value),
            };
            let unit = unit(value).ok_or_else(found)?;
            if self.unit.replace(unit).is_some_and(|before| before != unit) {
                return Err(found());
            }
            // Of `1 unit = 1000 mm` the unit is not mm.
            is_numbered |= number(value).0.is_some();
        }
        scale(comment)?;
        frame(comment)?;
        // Each once, however many comments there are.
        let axes = named_in(comment).into_iter();
        self.named
            .extend(axes.filter(|axes| !self.named.contains(axes)).collect::<Vec<_>>());
        let units = units_in(comment).into_iter().filter(|_| !is_numbered);
        self.units
            .extend(units.filter(|unit| !self.units.contains(unit)).collect::<Vec<_>>());
        Ok(())
    }
}

/// Refuses a scale that is not 1: `scale: 10 mm`.
fn scale(comment: &str) -> Result<(), MeshError> {
    let words = ["scale", "scaling", "scaled", "scale factor", "scaling factor"];
    let mut values = words
        .into_iter()
        .flat_map(|word| assigned(comment, word, &["by ", "is ", ""]));
    let is_other = |value: &&str| {
        let number = number(value).0;
        number.is_some_and(|number| number != 1.0)
    };
    match values.find(is_other) {
        Some(value) => Err(MeshError::Unit {
            found: crate::quoted(&format!("scale {value}")),
        }),
        None => Ok(()),
    }
}

/// Refuses a frame that has neither RAS nor LPS in it: `coordinate system: LAS`, `frame = scanner`.
fn frame(comment: &str) -> Result<(), MeshError> {
    for (place, _) in comment.match_indices(['=', ':']) {
        // Of the first words, as what stands behind each sign is looked at.
        let value: String = comment[place + 1..].chars().take(64).collect();
        let before = &comment[..place];
        let key = before.rsplit([',', ';', '=', ':']).next().unwrap_or_default();
        let last = key.trim_end().rsplit([' ', '\t']).next().unwrap_or_default();
        // `coordinate system` is two words; `1 unit` and `space` are read elsewhere.
        let is_key = last.eq_ignore_ascii_case("system") || about(last) == Some(About::Axes);
        let is_space = last.to_ascii_lowercase().ends_with("space");
        let is_read = || named_in(&value).iter().any(|named| named.axes.is_some());
        if is_key && !is_space && about(key) == Some(About::Axes) && !is_read() {
            let found = crate::quoted(comment[before.len() - key.len()..].trim());
            return Err(MeshError::Frame { found });
        }
    }
    Ok(())
}

/// What stands between the word and the unit where no sign does.
const VERBS: &[&str] = &["is ", "are ", "in "];

/// What stands behind `word =` or `word:` in a text, or behind one of the verbs, for each such word in whatever case, without quotation marks
/// and blanks before it.
fn assigned<'a>(text: &'a str, word: &'static str, verbs: &'static [&str]) -> impl Iterator<Item = &'a str> {
    // Of ASCII letters alone, so that places stay those of the text.
    let lower = text.to_ascii_lowercase();
    let places: Vec<usize> = lower.match_indices(word).map(|(place, _)| place).collect();
    places.into_iter().filter_map(move |place| {
        let (before, rest) = (&text[..place], &text[place + word.len()..]);
        let is_whole = !before.ends_with(|c: char| c.is_ascii_alphanumeric());
        let rest = rest.trim_start();
        let verb = || verbs.iter().find_map(|verb| rest.strip_prefix(verb));
        let value = rest.strip_prefix(['=', ':']).or_else(verb).filter(|_| is_whole)?;
        Some(value.trim_start_matches(|c: char| c.is_whitespace() || "\"'(=".contains(c)))
    })
}

/// The letters and digits at the beginning.
fn first_word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(text.len());
    &text[..end]
}

/// A unit as exporters write it, `1000.000000 mm`, `mm`, `meters`; `None` where it is neither 1 mm nor 1 m.
fn unit(text: &str) -> Option<LengthUnit> {
    let (number, word) = number(text);
    let mm = unit_of(first_word(word))?.mm() * number.unwrap_or(1.0);
    [LengthUnit::Millimetre, LengthUnit::Metre]
        .into_iter()
        .find(|unit| unit.mm() == mm)
}

/// A number at the beginning, and what follows it.
fn number(text: &str) -> (Option<f64>, &str) {
    let end = text
        .find(|c: char| !(c.is_ascii_digit() || "+-.,eE".contains(c)))
        .unwrap_or(text.len());
    // A word may begin with an `e` too: what is no number is none.
    match text[..end].parse().ok() {
        Some(number) => (Some(number), text[end..].trim_start()),
        None => (None, text),
    }
}

/// A count that a head promises, where it may be one.
pub(super) fn counted(what: &'static str, found: u64) -> Result<usize, MeshError> {
    let count = usize::try_from(found).ok().filter(|count| *count <= MAX_COUNT);
    count.ok_or(MeshError::TooMany { what, found })
}
