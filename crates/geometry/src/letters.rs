//! Orientation letters: where the patient's left, front and head are.

use crate::{Ct, Direction};

/// Components below this are not named: a direction within 11 degrees of an axis gets one letter.
const SMALLEST: f64 = 0.2;

/// The letters of a patient direction, largest component first: `L` left, `R` right, `A` anterior, `P` posterior, `S`
/// superior, `I` inferior (DICOM's F and H are feet and head; S and I are what surgeons read on CT consoles).
pub fn letters(direction: Direction<Ct>) -> String {
    const NAMES: [[char; 2]; 3] = [['L', 'R'], ['P', 'A'], ['S', 'I']];
    let components = direction.components();
    let mut named: Vec<(f64, char)> = (0..3)
        .filter(|&a| components[a].abs() >= SMALLEST)
        .map(|a| (components[a].abs(), NAMES[a][usize::from(components[a] < 0.0)]))
        .collect();
    named.sort_by(|a, b| b.0.total_cmp(&a.0));
    named.into_iter().map(|(_, letter)| letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;

    #[test]
    fn axes_and_obliques() {
        let of = |x, y, z| letters(Vector::new(x, y, z).direction().unwrap());
        assert_eq!(of(1.0, 0.0, 0.0), "L");
        assert_eq!(of(-1.0, 0.1, 0.0), "R");
        assert_eq!(of(0.0, -1.0, 0.0), "A");
        assert_eq!(of(0.0, 0.0, -1.0), "I");
        assert_eq!(of(1.0, -2.0, 0.5), "ALS");
    }
}
