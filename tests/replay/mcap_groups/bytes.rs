//! Records of an MCAP file, byte by byte (<https://mcap.dev/spec>).

const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// What stands behind the known fields of a padded record.
const PADDING: [u8; 3] = [1, 0xff, 0xff];
const FOOTER: u8 = 2;
const MESSAGE: u8 = 5;
const SUMMARY_OFFSET: u8 = 14;
const DATA_END: u8 = 15;

/// CRC-32 of IEEE 802.3.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 }
        })
    };
    !bytes.iter().fold(!0, step)
}

pub(crate) fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

pub(crate) fn map(pairs: &[(&str, &str)]) -> Vec<u8> {
    let pairs: Vec<u8> = pairs
        .iter()
        .flat_map(|(key, value)| [text(key), text(value)].concat())
        .collect();
    [&(pairs.len() as u32).to_le_bytes()[..], &pairs].concat()
}

pub(crate) fn u64s(numbers: &[u64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

pub(crate) fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &u64s(&[body.len() as u64]), body].concat()
}

/// A file being written.
pub(crate) struct File {
    bytes: Vec<u8>,
    pad: bool,
}

impl File {
    pub(crate) fn new(pad: bool) -> Self {
        let mut file = Self {
            bytes: MAGIC.to_vec(),
            pad,
        };
        file.put(1, &[text(""), text("")].concat());
        file
    }

    pub(crate) fn length(&self) -> u64 {
        self.bytes.len() as u64
    }

    pub(crate) fn put(&mut self, opcode: u8, body: &[u8]) {
        // Their last field has no end but the record's.
        let pad = self.pad && opcode != MESSAGE;
        self.put_bare(opcode, &[body, if pad { &PADDING } else { &[] }].concat());
    }

    /// The same, never padded.
    pub(crate) fn put_bare(&mut self, opcode: u8, body: &[u8]) {
        self.bytes.extend(record(opcode, body));
    }

    pub(crate) fn end_data(&mut self) {
        let sum = crc32(&self.bytes);
        self.put_bare(DATA_END, &sum.to_le_bytes());
    }

    /// The summary's groups of records, their offsets where asked for, and the end.
    pub(crate) fn finish(mut self, groups: &[Vec<(u8, Vec<u8>)>], offsets: bool) -> Vec<u8> {
        let start = self.length();
        let mut places = Vec::new();
        for group in groups {
            let at = self.length();
            group.iter().for_each(|(opcode, body)| self.put(*opcode, body));
            let opcode = group.first().map_or(0, |(opcode, _)| *opcode);
            places.push([&[opcode][..], &u64s(&[at, self.length() - at])].concat());
        }
        let summary = if self.length() > start { start } else { 0 };
        let mut offset_start = 0;
        if offsets {
            offset_start = self.length();
            places.iter().for_each(|body| self.put(SUMMARY_OFFSET, body));
        }
        let footer = u64s(&[summary, offset_start]);
        let head = [&[FOOTER][..], &u64s(&[20]), &footer].concat();
        let sum = crc32(&[&self.bytes[start as usize..], &head].concat());
        self.put_bare(FOOTER, &[&footer[..], &sum.to_le_bytes()].concat());
        self.bytes.extend(MAGIC);
        self.bytes
    }
}
