//! RLE Lossless, PS3.5 Annex G: the high bytes of all voxels, then the low bytes, each packed row by row.

/// A slice of `columns` voxels per row as one frame.
pub(super) fn frame(slice: &[i16], columns: usize) -> Vec<u8> {
    let mut out = vec![0; 64];
    let high = segment(slice, columns, |bytes| bytes[0]);
    let low = segment(slice, columns, |bytes| bytes[1]);
    // The number of segments, and where each one starts.
    for (at, word) in [2, 64, 64 + high.len() as u32].into_iter().enumerate() {
        out[4 * at..4 * at + 4].copy_from_slice(&word.to_le_bytes());
    }
    out.extend(high);
    out.extend(low);
    out
}

fn segment(slice: &[i16], columns: usize, byte: impl Fn([u8; 2]) -> u8) -> Vec<u8> {
    let mut out = Vec::with_capacity(slice.len() + slice.len() / 64 + 2);
    let mut row = Vec::with_capacity(columns);
    for voxels in slice.chunks(columns) {
        row.clear();
        row.extend(voxels.iter().map(|v| byte(v.to_be_bytes())));
        pack(&row, &mut out);
    }
    // Segments have an even length (G.4).
    if out.len() % 2 == 1 {
        out.push(0);
    }
    out
}

/// Runs of 2 to 128 equal bytes as (257 - length, byte), other stretches as (length - 1, bytes): section G.3.1.
fn pack(mut row: &[u8], out: &mut Vec<u8>) {
    while let Some(&first) = row.first() {
        let run = row.iter().take(128).take_while(|&&b| b == first).count();
        let taken = if run > 1 {
            out.extend([(257 - run) as u8, first]);
            run
        } else {
            let literal = literal_length(row);
            out.push((literal - 1) as u8);
            out.extend(&row[..literal]);
            literal
        };
        row = &row[taken..];
    }
}

/// Up to the next run of three, which is worth ending a stretch for.
fn literal_length(row: &[u8]) -> usize {
    let limit = row.len().min(128);
    let run = row[..limit].windows(3).position(|w| w[0] == w[1] && w[1] == w[2]);
    run.unwrap_or(limit).max(1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The decoder of section G.3.2.
    fn unpack(mut bytes: &[u8], length: usize) -> Vec<u8> {
        let mut out = Vec::new();
        while out.len() < length {
            let count = bytes[0] as i8;
            if count >= 0 {
                let end = 2 + count as usize;
                out.extend(&bytes[1..end]);
                bytes = &bytes[end..];
            } else if count != -128 {
                out.extend(std::iter::repeat_n(bytes[1], (1 - i32::from(count)) as usize));
                bytes = &bytes[2..];
            }
        }
        out
    }

    proptest! {
        #[test]
        fn what_is_packed_is_unpacked(voxels in proptest::collection::vec(prop_oneof![Just(-1000_i16), Just(40), any::<i16>()], 1..400), columns in 1_usize..50) {
            let bytes = frame(&voxels, columns);
            prop_assert_eq!(bytes.len() % 2, 0);
            let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
            prop_assert_eq!(word(0), 2);
            let high = unpack(&bytes[word(4)..word(8)], voxels.len());
            let low = unpack(&bytes[word(8)..], voxels.len());
            let found: Vec<i16> = high.iter().zip(&low).map(|(&h, &l)| i16::from_be_bytes([h, l])).collect();
            prop_assert_eq!(found, voxels);
        }
    }

    #[test]
    fn runs_are_short() {
        // Two segments, two rows each, 512 voxels a row in runs of 128: 8 bytes a row.
        assert_eq!(frame(&[-1024; 1024], 512).len(), 64 + 2 * 2 * 8);
    }
}
