//! The examination's name as a person saw it.

use guidance::workflow::VolumeId;

/// The examination with this hash in hex, either case; `None` where it is no hash.
pub(super) fn volume(hex: &str) -> Option<VolumeId> {
    let digits: Vec<u8> = hex
        .chars()
        .map(|c| c.to_digit(16).map(|d| d as u8))
        .collect::<Option<_>>()?;
    let pairs: Vec<u8> = digits.chunks_exact(2).map(|pair| 16 * pair[0] + pair[1]).collect();
    match digits.len() {
        64 => Some(VolumeId(pairs.try_into().ok()?)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::VolumeHash;

    #[test]
    fn hashes_come_back_and_nothing_else_is_one() {
        let hash: [u8; 32] = std::array::from_fn(|i| (7 * i + 3) as u8);
        let words = VolumeHash(hash).to_string();
        assert_eq!(volume(&words), Some(VolumeId(hash)));
        assert_eq!(volume(&words.to_uppercase()), Some(VolumeId(hash)));
        for bad in [
            "",
            &words[1..],
            &format!("{words}0"),
            &words.replace('0', "g"),
            &"é".repeat(32),
        ] {
            assert_eq!(volume(bad), None, "{bad}");
        }
    }
}
