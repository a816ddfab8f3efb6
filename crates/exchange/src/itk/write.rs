//! From a transform to the text of a file.

use geometry::Rigid;

/// The text of a file that maps points of `From` to points of `To`, as [`super::read()`] reads it: a matrix about the origin, which ITK
/// and 3D Slicer take as a linear transform. Each number has the digits that bring back every bit.
pub fn write<To, From>(to_from_from: &Rigid<To, From>) -> String {
    let rows = to_from_from.rotation().matrix().rows();
    let translation = to_from_from.translation_mm();
    let numbers = rows.as_flattened().iter().chain(&translation);
    let words: Vec<String> = numbers.map(f64::to_string).collect();
    format!(
        "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\nParameters: {}\nFixedParameters: 0 0 0\n",
        words.join(" ")
    )
}
