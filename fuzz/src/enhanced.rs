//! Enhanced CT files of three frames, as seeds: no program of ours writes such files.

const COLUMNS: u16 = 4;
const ROWS: u16 = 3;
/// As NumberOfFrames says it, too.
const FRAMES: u16 = 3;

type Tag = (u16, u16);

/// An element in explicit little endian.
fn element((group, number): Tag, vr: &str, value: &[u8]) -> Vec<u8> {
    let mut bytes = [group.to_le_bytes(), number.to_le_bytes()].concat();
    bytes.extend(vr.as_bytes());
    let length = value.len().next_multiple_of(2) as u32;
    match vr {
        "SQ" | "OB" | "OW" | "OV" => bytes.extend([[0; 2].as_slice(), &length.to_le_bytes()].concat()),
        _ => bytes.extend((length as u16).to_le_bytes()),
    }
    bytes.extend(value);
    if value.len() % 2 == 1 {
        bytes.push(if vr == "UI" { 0 } else { b' ' });
    }
    bytes
}

fn item(content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xFE, 0xFF, 0x00, 0xE0];
    bytes.extend((content.len() as u32).to_le_bytes());
    bytes.extend(content);
    bytes
}

/// A functional group of one item.
fn group(tag: Tag, elements: &[Vec<u8>]) -> Vec<u8> {
    element(tag, "SQ", &item(&elements.concat()))
}

fn shared() -> Vec<u8> {
    let orientation = element((0x0020, 0x0037), "DS", b"1\\0\\0\\0\\1\\0");
    let spacing = element((0x0028, 0x0030), "DS", b"0.75\\0.75");
    let scale = [
        element((0x0028, 0x1052), "DS", b"-1024"),
        element((0x0028, 0x1053), "DS", b"1"),
    ];
    let groups = [
        group((0x0020, 0x9116), &[orientation]),
        group((0x0028, 0x9110), &[spacing]),
        group((0x0028, 0x9145), &scale),
    ];
    element((0x5200, 0x9229), "SQ", &item(&groups.concat()))
}

fn frames() -> Vec<u8> {
    let frame = |k: u16| {
        let content = [
            element((0x0020, 0x9056), "SH", b"1"),
            element((0x0020, 0x9057), "UL", &(u32::from(k) + 1).to_le_bytes()),
            element((0x0020, 0x9128), "UL", &1_u32.to_le_bytes()),
        ];
        let position = element((0x0020, 0x0032), "DS", format!("0\\0\\{}", 2 * k).as_bytes());
        item(&[group((0x0020, 0x9111), &content), group((0x0020, 0x9113), &[position])].concat())
    };
    element(
        (0x5200, 0x9230),
        "SQ",
        &(0..FRAMES).flat_map(frame).collect::<Vec<u8>>(),
    )
}

/// A file with these elements behind the functional groups.
fn file(syntax: &str, tail: &[u8]) -> Vec<u8> {
    let class = b"1.2.840.10008.5.1.4.1.1.2.1";
    let mut bytes = vec![0; 128];
    bytes.extend(b"DICM");
    bytes.extend(element((0x0002, 0x0010), "UI", syntax.as_bytes()));
    let texts: [(Tag, &str, &[u8]); 8] = [
        ((0x0008, 0x0016), "UI", class),
        ((0x0008, 0x0018), "UI", b"1.2.3"),
        ((0x0008, 0x0060), "CS", b"CT"),
        ((0x0020, 0x000D), "UI", b"1.2.4"),
        ((0x0020, 0x000E), "UI", b"1.2.5"),
        ((0x0020, 0x0052), "UI", b"1.2.6"),
        ((0x0028, 0x0004), "CS", b"MONOCHROME2"),
        ((0x0028, 0x0008), "IS", b"3"),
    ];
    texts
        .iter()
        .for_each(|(tag, vr, text)| bytes.extend(element(*tag, vr, text)));
    let numbers = [
        (0x0002, 1),
        (0x0010, ROWS),
        (0x0011, COLUMNS),
        (0x0100, 16),
        (0x0101, 12),
        (0x0102, 11),
        (0x0103, 0),
    ];
    let number = |(tag, value): (u16, u16)| element((0x0028, tag), "US", &value.to_le_bytes());
    bytes.extend(numbers.into_iter().flat_map(number));
    bytes.extend([shared(), frames(), tail.to_vec()].concat());
    bytes
}

/// Uncompressed.
pub(crate) fn native() -> Vec<u8> {
    let pixels: Vec<u8> = (0..FRAMES * ROWS * COLUMNS).flat_map(u16::to_le_bytes).collect();
    file("1.2.840.10008.1.2.1", &element((0x7FE0, 0x0010), "OW", &pixels))
}

/// RLE, with the extended table of offsets.
pub(crate) fn packed() -> Vec<u8> {
    let mut stream = Vec::new();
    [2_u32, 64, 66]
        .into_iter()
        .chain([0; 13])
        .for_each(|word| stream.extend(word.to_le_bytes()));
    let pixels = (ROWS * COLUMNS) as u8;
    stream.extend([(257 - u16::from(pixels)) as u8, 0, pixels - 1]);
    stream.extend(0..=pixels);
    let length = stream.len() as u64;
    let table = |number: fn(u64, u64) -> u64| {
        let numbers = (0..u64::from(FRAMES)).flat_map(|k| number(k, length).to_le_bytes());
        numbers.collect::<Vec<u8>>()
    };
    let mut tail = element((0x7FE0, 0x0001), "OV", &table(|k, length| k * (8 + length)));
    tail.extend(element((0x7FE0, 0x0002), "OV", &table(|_, length| length)));
    tail.extend([0xE0, 0x7F, 0x10, 0x00, b'O', b'B', 0, 0, 0xFF, 0xFF, 0xFF, 0xFF]);
    tail.extend(item(&[]));
    (0..FRAMES).for_each(|_| tail.extend(item(&stream)));
    tail.extend([0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
    file("1.2.840.10008.1.2.5", &tail)
}

#[cfg(test)]
mod tests {
    use scene::{FileSpec, VolumeSource, VolumeSpec};

    /// A seed that is refused at once would try nothing.
    #[test]
    fn both_seeds_are_read_to_their_end() {
        for bytes in [super::native(), super::packed()] {
            let folder = crate::Folder::new().unwrap();
            let path = folder.file("many.dcm", &bytes).unwrap();
            let spec = VolumeSpec {
                source: VolumeSource::File(FileSpec {
                    path,
                    ..FileSpec::default()
                }),
                region: None,
                downsample: [1; 3],
                hash: None,
            };
            let mut source = volume_loader::open(&spec, 1).unwrap();
            let mut slice = [0; 12];
            (0..3).for_each(|k| source.read_slice(k, &mut slice).unwrap());
            source.finish().unwrap();
        }
    }
}
