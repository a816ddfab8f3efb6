//! Messages that are passed on unread: their types are known, or not, and their content is kept as it came.
//!
//! Where the protocol says how long a content of a type must be, it is held against that, so that a wrong one is told
//! apart from one that nobody reads.

use crate::fault::SizeRule;
use crate::malformed::Refusal;
use crate::name::TypeName;
use crate::wire::Reader;

/// How long the content of a type may be, of those that are not read here.
pub(crate) fn rule(kind: &TypeName) -> SizeRule {
    match kind.as_bytes() {
        // Each of a label, a trajectory, a video.
        b"LBMETA" => SizeRule::MultipleOf(116),
        b"TRAJ" => SizeRule::MultipleOf(150),
        b"VIDEOMETA" => SizeRule::MultipleOf(322),
        // Number, status and unit before the values; index and map before the table; type and axes; number of children.
        b"SENSOR" => SizeRule::AtLeast(10),
        b"COLORT" | b"COLORTABLE" => SizeRule::AtLeast(2),
        b"NDARRAY" => SizeRule::AtLeast(2),
        b"BIND" => SizeRule::AtLeast(2),
        _ => SizeRule::AtLeast(0),
    }
}

/// What a SENSOR, a COLORT and an NDARRAY say of their own length.
fn announced(kind: &TypeName, mut content: Reader<'_>) -> Result<SizeRule, Refusal> {
    Ok(match kind.as_bytes() {
        b"SENSOR" => SizeRule::Exactly(10 + 8 * u64::from(content.u8()?)),
        b"COLORT" | b"COLORTABLE" => match content.array()? {
            [index @ (3 | 5), map @ (3 | 5 | 19)] => {
                let entries = if index == 3 { 256 } else { 65536 };
                let bytes = match map {
                    3 => 1,
                    5 => 2,
                    _ => 3,
                };
                SizeRule::Exactly(2 + entries * bytes)
            }
            _ => SizeRule::AtLeast(2),
        },
        b"NDARRAY" => {
            let [scalar, axes] = content.array()?;
            let bytes = match scalar {
                2 | 3 => 1,
                4 | 5 => 2,
                6 | 7 | 10 => 4,
                11 => 8,
                13 => 16,
                _ => return Ok(SizeRule::AtLeast(2)),
            };
            let mut numbers = 1_u64;
            for _ in 0..axes {
                numbers = numbers.saturating_mul(content.u16()?.into());
            }
            SizeRule::Exactly(numbers.saturating_mul(bytes).saturating_add(2 + 2 * u64::from(axes)))
        }
        _ => SizeRule::AtLeast(0),
    })
}

/// The content as it came.
pub(crate) fn read<'a>(kind: &TypeName, reader: &mut Reader<'a>) -> Result<&'a [u8], Refusal> {
    reader.sized(rule(kind))?;
    reader.sized(announced(kind, reader.clone())?)?;
    Ok(reader.rest())
}
