//! OBJ: text, of which points and faces are read.

use super::raw::{Raw, counted};
use super::{MAX_COUNT, MeshError};
use crate::quoted;

/// Lines of these words are left out: they move no point.
const LEFT_OUT: [&str; 11] = ["vn", "vt", "vp", "g", "o", "s", "mtllib", "usemtl", "l", "p", "mg"];

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshError> {
    let mut raw = Raw::default();
    let mut is_any = false;
    for (line, number) in bytes.split(|byte| *byte == b'\n').zip(1..) {
        let refused = |expected| MeshError::Word {
            line: number,
            found: quoted(&String::from_utf8_lossy(&line[..line.len().min(64)])),
            expected,
        };
        let text = std::str::from_utf8(line).map_err(|_| refused("text"))?.trim();
        if let Some(comment) = text.strip_prefix('#') {
            raw.comment(comment)?;
            continue;
        }
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            None => continue,
            Some("v") => {
                // Behind the three may stand a weight or a colour.
                let numbers: Vec<f64> = words.take(3).filter_map(|word| word.parse().ok()).collect();
                let point = numbers.try_into().map_err(|_| refused("v and three numbers"))?;
                raw.points.push(point);
                counted("points", raw.points.len() as u64)?;
            }
            Some("f") => {
                let count = raw.points.len();
                let corners: Option<Vec<u32>> = words.map(|word| corner(word, count)).collect();
                let corners = corners.ok_or_else(|| refused("f and the numbers of points, from 1 or back from -1"))?;
                let place = raw.triangles.len() + 1;
                raw.polygon(place, &corners)?;
            }
            Some(word) if LEFT_OUT.contains(&word) => {}
            Some(_) => {
                return Err(refused(
                    "v, f, or a line that is left out (vn, vt, g, o, s, l, p, materials)",
                ));
            }
        }
        is_any = true;
    }
    match is_any {
        true => Ok(raw),
        false => Err(MeshError::Empty),
    }
}

/// A corner `point/texture/normal`, the point from 1 on or from the last one back.
fn corner(word: &str, count: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let count = i64::try_from(count).ok()?;
    let place = match number {
        1.. => number - 1,
        _ if number < 0 => count + number,
        _ => return None,
    };
    u32::try_from(place).ok().filter(|place| (*place as usize) < MAX_COUNT)
}
