//! Two ways to say where a slice's rows and columns point, which may not contradict one another: PatientOrientation in letters and
//! ImageOrientationPatient in cosines (DICOM PS3.3, C.7.6.1.1.1).

use crate::dicom::error::FileError;
use crate::dicom::header::{Header, Placed};

/// The first letter is the nearest side: 1/sqrt(3) at least, with room for how a writer rounds.
const NEAREST: f64 = 0.5;
/// The other letters may be left out or rounded, and point no farther than this to the opposite side.
const OPPOSITE: f64 = 0.01;
/// The sides of a person and where they are along x, y and z (LPS).
const SIDES: [(u8, usize, f64); 6] = [
    (b'L', 0, 1.0),
    (b'R', 0, -1.0),
    (b'P', 1, 1.0),
    (b'A', 1, -1.0),
    (b'H', 2, 1.0),
    (b'F', 2, -1.0),
];

/// Refuses a slice whose rows or columns point to other sides by its letters than by its cosines: one of them shows a patient who is
/// mirrored or turned.
///
/// # Errors
/// [`FileError::Sides`].
pub(crate) fn check(header: &Header) -> Result<(), FileError> {
    let (Some(letters), Ok(placed)) = (in_letters(header), header.placed) else {
        return Ok(());
    };
    let axes = axes(&placed);
    if letters.iter().zip(axes).all(|(letters, axis)| points(letters, axis)) {
        return Ok(());
    }
    Err(FileError::Sides {
        found: letters.join("\\"),
        expected: format!(
            "\"{}\" by ImageOrientationPatient \"{}\"",
            axes.map(in_words).join("\\"),
            placed.orientation.map(|cosine| cosine.to_string()).join("\\")
        ),
    })
}

/// How many slices say something that was not compared.
pub(crate) fn not_compared(headers: &[&Header]) -> Option<String> {
    let unread = headers
        .iter()
        .filter(|header| header.sides.is_some() && in_letters(header).is_none());
    let count = unread.count();
    (count > 0).then(|| {
        format!(
            "PatientOrientation of {count} of {} slices is not two directions by the letters A, P, R, L, H and F of a person: it was not \
             compared with ImageOrientationPatient, which is taken",
            headers.len()
        )
    })
}

/// The letters of the rows' and of the columns' direction, where they are those of a person.
fn in_letters(header: &Header) -> Option<[&str; 2]> {
    let mut parts = header
        .sides
        .as_ref()?
        .split('\\')
        .map(|part| part.trim_matches([' ', '\0']));
    let letters = [parts.next()?, parts.next()?];
    let is_direction = |letters: &str| {
        (1..=3).contains(&letters.len()) && letters.bytes().all(|letter| SIDES.iter().any(|side| side.0 == letter))
    };
    (header.is_person && parts.next().is_none() && letters.iter().all(|part| is_direction(part))).then_some(letters)
}

fn axes(placed: &Placed) -> [[f64; 3]; 2] {
    let [ax, ay, az, bx, by, bz] = placed.orientation;
    [[ax, ay, az], [bx, by, bz]]
}

fn points(letters: &str, axis: [f64; 3]) -> bool {
    let along = |letter: u8| {
        let side = SIDES.iter().find(|side| side.0 == letter);
        side.and_then(|(_, at, sign)| Some(sign * axis.get(*at)?))
    };
    let mut all = letters.bytes().map(|letter| along(letter).unwrap_or(f64::NAN));
    // Not a number points nowhere.
    all.next().is_some_and(|nearest| nearest >= NEAREST) && all.all(|other| other >= -OPPOSITE)
}

/// The letters of a direction, the nearest side first.
fn in_words(axis: [f64; 3]) -> String {
    let mut all: Vec<(f64, char)> = SIDES
        .iter()
        .filter_map(|(letter, at, sign)| Some((sign * axis.get(*at)?, char::from(*letter))))
        .filter(|(along, _)| *along > OPPOSITE)
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().map(|(_, letter)| letter).collect()
}
