//! A list of cells of a POLYDATA, as it lies on the wire.

use crate::fault::{Fault, SizeRule};
use crate::malformed::Refusal;
use crate::wire::{Reader, long};

/// Cells, each of some points by their numbers. Held as on the wire: the number of points of a cell, then the points,
/// cell by cell.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cells {
    count: u32,
    numbers: Vec<u32>,
}

impl Cells {
    /// Of cells; `None` where there are more than the wire can count.
    pub fn new<'a>(cells: impl IntoIterator<Item = &'a [u32]>) -> Option<Self> {
        let mut list = Self::default();
        for cell in cells {
            list.count = list.count.checked_add(1)?;
            list.numbers.push(u32::try_from(cell.len()).ok()?);
            list.numbers.extend(cell);
        }
        Some(list)
    }

    /// How many there are.
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// Each of them: the numbers of its points.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = &self.numbers[..];
        std::iter::from_fn(move || {
            let (cell, behind) = split(rest)?;
            rest = behind;
            Some(cell)
        })
    }

    pub(crate) fn bytes(&self) -> usize {
        self.numbers.len().saturating_mul(size_of::<u32>())
    }

    /// Whether each names points that are there, and the list has as many cells as it says.
    pub(crate) fn check(&self, points: u32, field: &'static str) -> Result<(), Fault> {
        let (mut rest, mut found) = (&self.numbers[..], 0_u64);
        let cells = |found| Fault::Cells {
            field,
            found,
            said: self.count.into(),
        };
        while !rest.is_empty() {
            let (cell, behind) = split(rest).ok_or_else(|| cells(found))?;
            if let Some(missing) = cell.iter().find(|point| **point >= points) {
                return Err(Fault::PointIndex {
                    found: *missing,
                    points,
                });
            }
            (rest, found) = (behind, found + 1);
        }
        if found == u64::from(self.count) {
            Ok(())
        } else {
            Err(cells(found))
        }
    }

    pub(crate) fn read(
        reader: &mut Reader<'_>,
        count: u32,
        bytes: u32,
        points: u32,
        field: &'static str,
    ) -> Result<Self, Refusal> {
        if !bytes.is_multiple_of(4) {
            return Err(reader.refuse(Fault::Size {
                found: bytes.into(),
                rule: SizeRule::MultipleOf(4),
            }));
        }
        let before = reader.clone();
        let (numbers, _) = reader.take(bytes.into())?.as_chunks::<4>();
        let numbers = numbers.iter().map(|number| u32::from_be_bytes(*number)).collect();
        let list = Self { count, numbers };
        list.check(points, field).map_err(|fault| before.refuse(fault))?;
        Ok(list)
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) {
        self.numbers.iter().for_each(|number| out.extend(number.to_be_bytes()));
    }
}

/// The first cell, and the numbers behind it; `None` where it is longer than what is there.
fn split(numbers: &[u32]) -> Option<(&[u32], &[u32])> {
    let (length, rest) = numbers.split_first()?;
    if u64::from(*length) > long(rest.len()) {
        return None;
    }
    rest.split_at_checked(usize::try_from(*length).ok()?)
}
