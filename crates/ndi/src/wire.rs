//! Numbers in the order of binary replies: little endian, packed without gaps.

use crate::fault::Fault;
use crate::malformed::Refusal;

/// A length as messages count it.
pub(crate) fn long(length: usize) -> u64 {
    u64::try_from(length).unwrap_or(u64::MAX)
}

/// Reads fields one after the other and knows where it is.
#[derive(Debug, Clone)]
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    /// The byte behind the last one.
    end: u64,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            end: long(bytes.len()),
        }
    }

    pub(crate) fn left(&self) -> u64 {
        long(self.rest.len())
    }

    pub(crate) fn at(&self) -> u64 {
        self.end - self.left()
    }

    pub(crate) fn refuse(&self, fault: Fault) -> Refusal {
        Refusal { fault, at: self.at() }
    }

    pub(crate) fn take(&mut self, count: usize, field: &'static str) -> Result<&'a [u8], Refusal> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err(self.refuse(Fault::Ends {
                field,
                needed: long(count),
                found: self.left(),
            }));
        };
        self.rest = rest;
        Ok(taken)
    }

    /// The next `count` bytes as a reader of their own, whose places are those of this one.
    pub(crate) fn part(&mut self, count: usize, field: &'static str) -> Result<Self, Refusal> {
        let rest = self.take(count, field)?;
        Ok(Self { rest, end: self.at() })
    }

    pub(crate) fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], Refusal> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N, field)?);
        Ok(array)
    }

    pub(crate) fn u8(&mut self, field: &'static str) -> Result<u8, Refusal> {
        self.array(field).map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self, field: &'static str) -> Result<u16, Refusal> {
        self.array(field).map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self, field: &'static str) -> Result<u32, Refusal> {
        self.array(field).map(u32::from_le_bytes)
    }

    /// Numbers of single precision, as they are: NaN too.
    pub(crate) fn reals<const N: usize>(&mut self, field: &'static str) -> Result<[f64; N], Refusal> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from(self.array(field).map(f32::from_le_bytes)?);
        }
        Ok(numbers)
    }

    /// How many elements of at least `size` bytes are said to follow; they must fit into what is left.
    pub(crate) fn count(&self, said: u32, size: u64, what: &'static str) -> Result<usize, Refusal> {
        let most = self.left() / size;
        match usize::try_from(said) {
            Ok(count) if u64::from(said) <= most => Ok(count),
            _ => Err(self.refuse(Fault::TooMany {
                what,
                found: said.into(),
                most,
            })),
        }
    }

    /// Nothing may be left.
    pub(crate) fn done(&self, field: &'static str) -> Result<(), Refusal> {
        match self.left() {
            0 => Ok(()),
            found => Err(self.refuse(Fault::Trailing { field, found })),
        }
    }
}

/// Appends numbers in single precision, which is what the wire has.
pub(crate) fn put_reals(out: &mut Vec<u8>, numbers: &[f64]) {
    #[allow(clippy::cast_possible_truncation, reason = "the wire has single precision")]
    numbers
        .iter()
        .for_each(|number| out.extend((*number as f32).to_le_bytes()));
}
