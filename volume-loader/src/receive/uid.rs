//! Unique identifiers as names of files and folders.

use std::fmt;

/// A UID has at most so many characters (PS3.5 section 9.1).
const MAX: usize = 64;

/// A unique identifier: 1 to 64 digits and points, no component of it empty. A name of a file that leads nowhere else.
///
/// A component that begins with a zero is let pass, though the standard has none: scanners write them, and they harm nobody.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Uid(String);

impl Uid {
    /// The UID in these bytes, without the zero byte or spaces that pad it; `None` where they are none.
    pub(crate) fn checked(bytes: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(bytes).ok()?.trim_end_matches(['\0', ' ']);
        let is_component = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        (text.len() <= MAX && text.split('.').all(is_component)).then(|| Self(text.to_owned()))
    }

    /// As text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Uid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn only_digits_and_points_make_a_name() {
        let long = "1".repeat(65);
        for bad in [
            "",
            ".",
            "..",
            "../1",
            "1.2/3",
            "1..2",
            ".1",
            "1.",
            "1.2.a",
            "1 2",
            "/etc",
            "1\x002",
            "-1",
            "1.2\n",
            long.as_str(),
            "１.2",
        ] {
            assert_eq!(Uid::checked(bad.as_bytes()), None, "{bad:?}");
        }
        for good in ["1.2.840.10008", "0", "1.0.3", "1.02", &long[..64]] {
            assert_eq!(Uid::checked(good.as_bytes()).unwrap().as_str(), good);
        }
        assert_eq!(Uid::checked(b"1.2\0").unwrap().as_str(), "1.2");
        assert_eq!(Uid::checked(&[0xff, 0x31]), None);
    }

    proptest! {
        #[test]
        fn whatever_passes_is_one_plain_name(
            bytes in prop::collection::vec(prop_oneof![Just(b'.'), Just(b'1'), Just(b'/'), any::<u8>()], 0..70),
        ) {
            if let Some(uid) = Uid::checked(&bytes) {
                let path = std::path::Path::new(uid.as_str());
                prop_assert_eq!(path.file_name().unwrap(), uid.as_str());
                prop_assert_eq!(path.components().count(), 1);
                prop_assert!(!uid.as_str().starts_with('.'));
            }
        }
    }
}
