//! Numbers and names in the order of the wire: big endian, packed without gaps.

use crate::fault::{Fault, SizeRule, not_finite};
use crate::malformed::Refusal;
use crate::name::{Charset, Name};

/// Reads fields one after the other and knows where it is.
#[derive(Debug, Clone)]
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    /// The byte of the message at which the content begins.
    start: u64,
    size: u64,
}

/// A length as the wire counts it.
pub(crate) fn long(length: usize) -> u64 {
    u64::try_from(length).unwrap_or(u64::MAX)
}

impl<'a> Reader<'a> {
    /// Over `bytes`, the first of which is number `start` of its message.
    pub(crate) fn new(bytes: &'a [u8], start: u64) -> Self {
        let size = long(bytes.len());
        Self {
            rest: bytes,
            start,
            size,
        }
    }

    /// All bytes, read or not.
    pub(crate) const fn size(&self) -> u64 {
        self.size
    }

    pub(crate) fn left(&self) -> u64 {
        long(self.rest.len())
    }

    /// The byte of the message that is read next.
    pub(crate) fn at(&self) -> u64 {
        self.start + self.size - self.left()
    }

    pub(crate) fn refuse(&self, fault: Fault) -> Refusal {
        Refusal { fault, at: self.at() }
    }

    /// Holds the content's size against what its type allows.
    pub(crate) fn sized(&self, rule: SizeRule) -> Result<(), Refusal> {
        if rule.admits(self.size) {
            return Ok(());
        }
        Err(self.refuse(Fault::Size { found: self.size, rule }))
    }

    /// How many elements of `size` bytes there are, at most `most`; bytes that are left over are refused.
    pub(crate) fn elements(&self, size: u64, what: &'static str, most: u32) -> Result<usize, Refusal> {
        self.sized(SizeRule::MultipleOf(size))?;
        let found = self.size / size;
        let most = u64::from(most);
        match usize::try_from(found) {
            Ok(count) if found <= most => Ok(count),
            _ => Err(self.refuse(Fault::TooMany { what, found, most })),
        }
    }

    pub(crate) fn take(&mut self, count: u64) -> Result<&'a [u8], Refusal> {
        let split = usize::try_from(count)
            .ok()
            .and_then(|count| self.rest.split_at_checked(count));
        let Some((taken, rest)) = split else {
            let least = (self.size - self.left()).saturating_add(count);
            return Err(self.refuse(Fault::Size {
                found: self.size,
                rule: SizeRule::AtLeast(least),
            }));
        };
        self.rest = rest;
        Ok(taken)
    }

    pub(crate) fn rest(&mut self) -> &'a [u8] {
        std::mem::take(&mut self.rest)
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Result<[u8; N], Refusal> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(long(N))?);
        Ok(array)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, Refusal> {
        self.array().map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self) -> Result<u16, Refusal> {
        self.array().map(u16::from_be_bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Refusal> {
        self.array().map(u32::from_be_bytes)
    }

    pub(crate) fn u64(&mut self) -> Result<u64, Refusal> {
        self.array().map(u64::from_be_bytes)
    }

    pub(crate) fn i64(&mut self) -> Result<i64, Refusal> {
        self.array().map(i64::from_be_bytes)
    }

    pub(crate) fn u16s<const N: usize>(&mut self) -> Result<[u16; N], Refusal> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.u16()?;
        }
        Ok(numbers)
    }

    /// A finite number of single precision.
    pub(crate) fn real(&mut self, field: &'static str) -> Result<f32, Refusal> {
        let before = self.clone();
        let value = self.array().map(f32::from_be_bytes)?;
        match not_finite(value.into()) {
            None => Ok(value),
            Some(value) => Err(before.refuse(Fault::NotFinite { field, value })),
        }
    }

    pub(crate) fn reals<const N: usize>(&mut self, field: &'static str) -> Result<[f32; N], Refusal> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.real(field)?;
        }
        Ok(numbers)
    }

    /// A name of printable ASCII.
    pub(crate) fn name<const N: usize>(&mut self, field: &'static str) -> Result<Name<N>, Refusal> {
        self.text(field, Charset::Ascii, "printable ASCII")
    }

    /// A label of anything but control characters.
    pub(crate) fn label<const N: usize>(&mut self, field: &'static str) -> Result<Name<N>, Refusal> {
        self.text(field, Charset::Any, "anything but control characters")
    }

    /// A label in which whatever may not stand in one has become `?`.
    pub(crate) fn scrubbed<const N: usize>(&mut self) -> Result<Name<N>, Refusal> {
        Ok(Name::scrubbed(self.array()?))
    }

    fn text<const N: usize>(
        &mut self,
        field: &'static str,
        charset: Charset,
        allowed: &'static str,
    ) -> Result<Name<N>, Refusal> {
        let at = self.at();
        Name::from_wire(self.array()?, charset).map_err(|(place, byte)| Refusal {
            fault: Fault::NameByte { field, byte, allowed },
            at: at + long(place),
        })
    }
}

/// Appends a number that must be finite.
pub(crate) fn put_real(out: &mut Vec<u8>, value: f32, field: &'static str) -> Result<(), Fault> {
    match not_finite(value.into()) {
        Some(value) => Err(Fault::NotFinite { field, value }),
        None => {
            out.extend(value.to_be_bytes());
            Ok(())
        }
    }
}

/// Appends numbers that must be finite.
pub(crate) fn put_reals(out: &mut Vec<u8>, values: &[f32], field: &'static str) -> Result<(), Fault> {
    values.iter().try_for_each(|value| put_real(out, *value, field))
}

/// Appends numbers of sixteen bits.
pub(crate) fn put_u16s(out: &mut Vec<u8>, values: &[u16]) {
    values.iter().for_each(|value| out.extend(value.to_be_bytes()));
}

/// A length that is to stand in fewer bits.
pub(crate) fn counted<T: TryFrom<usize>>(length: usize, what: &'static str, most: u64) -> Result<T, Fault> {
    T::try_from(length).map_err(|_| Fault::TooMany {
        what,
        found: long(length),
        most,
    })
}
