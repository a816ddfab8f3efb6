//! A writer of small DICOM files, for tests only.

/// How elements are coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    Implicit,
    Explicit,
    Big,
}

/// An element's value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    /// Text of this representation.
    Text(&'static str, String),
    /// 16-bit numbers.
    Us(u16),
    /// Anything, as it stands, with its length as it is claimed.
    Raw(&'static str, Vec<u8>, u32),
    /// A sequence: its items' elements, and whether delimiters end it and them.
    Items(Vec<Vec<((u16, u16), Value)>>, bool),
}

/// One file: its elements, in the order of their tags.
#[derive(Debug, Clone)]
pub(crate) struct File {
    pub coding: Coding,
    pub syntax: String,
    pub preamble: bool,
    pub elements: Vec<((u16, u16), Value)>,
}

pub(crate) const SIZE: [u16; 2] = [4, 3];

impl File {
    /// A CT slice of 4 x 3 pixels of 16 bits, `z` mm up, whose stored pixels are 100 * k + 0 to 11.
    pub(crate) fn slice(k: usize, z: f64) -> Self {
        let mut file = Self {
            coding: Coding::Explicit,
            syntax: "1.2.840.10008.1.2.1".to_owned(),
            preamble: true,
            elements: Vec::new(),
        };
        let text = [
            ((0x0008, 0x0008), "CS", "ORIGINAL\\PRIMARY\\AXIAL"),
            ((0x0008, 0x0016), "UI", "1.2.840.10008.5.1.4.1.1.2"),
            ((0x0008, 0x0060), "CS", "CT"),
            ((0x0010, 0x0010), "PN", "SECRET^NAME"),
            ((0x0018, 0x0050), "DS", "0.6"),
            ((0x0020, 0x000D), "UI", "1.2.3.4"),
            ((0x0020, 0x000E), "UI", "1.2.3.4.5"),
            ((0x0020, 0x0013), "IS", "7"),
            ((0x0020, 0x0037), "DS", "1\\0\\0\\0\\1\\0"),
            ((0x0020, 0x0052), "UI", "1.2.3.4.6"),
            ((0x0028, 0x0004), "CS", "MONOCHROME2"),
            ((0x0028, 0x0030), "DS", "0.75\\0.5"),
            ((0x0028, 0x1052), "DS", "-1024"),
            ((0x0028, 0x1053), "DS", "1"),
        ];
        for (tag, vr, value) in text {
            file.text(tag, vr, value);
        }
        file.text((0x0020, 0x0032), "DS", &format!("-10\\20\\{z}"));
        let numbers = [
            (0x0002, 1),
            (0x0010, SIZE[1]),
            (0x0011, SIZE[0]),
            (0x0100, 16),
            (0x0101, 12),
            (0x0102, 11),
            (0x0103, 0),
        ];
        for (element, value) in numbers {
            file.us((0x0028, element), value);
        }
        let pixels: Vec<u16> = (0..SIZE[0] * SIZE[1]).map(|i| 100 * k as u16 + i).collect();
        file.pixels(&pixels);
        file
    }

    pub(crate) fn set(&mut self, tag: (u16, u16), value: Value) -> &mut Self {
        self.remove(tag);
        let at = self.elements.partition_point(|row| row.0 < tag);
        self.elements.insert(at, (tag, value));
        self
    }

    pub(crate) fn remove(&mut self, tag: (u16, u16)) -> &mut Self {
        self.elements.retain(|row| row.0 != tag);
        self
    }

    pub(crate) fn text(&mut self, tag: (u16, u16), vr: &'static str, text: &str) -> &mut Self {
        self.set(tag, Value::Text(vr, text.to_owned()))
    }

    pub(crate) fn us(&mut self, tag: (u16, u16), value: u16) -> &mut Self {
        self.set(tag, Value::Us(value))
    }

    pub(crate) fn raw(&mut self, tag: (u16, u16), vr: &'static str, bytes: &[u8]) -> &mut Self {
        self.set(tag, Value::Raw(vr, bytes.to_vec(), bytes.len() as u32))
    }

    /// Uncompressed pixels of 16 bits, in the file's byte order: call after [`File::coded`].
    pub(crate) fn pixels(&mut self, pixels: &[u16]) -> &mut Self {
        let big = self.coding == Coding::Big;
        let bytes = |p: &u16| if big { p.to_be_bytes() } else { p.to_le_bytes() };
        let bytes: Vec<u8> = pixels.iter().flat_map(bytes).collect();
        self.raw((0x7FE0, 0x0010), "OW", &bytes)
    }

    /// One frame, as these fragments.
    pub(crate) fn fragments(&mut self, syntax: &str, fragments: &[&[u8]]) -> &mut Self {
        let mut bytes = item(&[]);
        fragments.iter().for_each(|fragment| bytes.extend(item(fragment)));
        bytes.extend([0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
        self.syntax = format!("1.2.840.10008.1.2{syntax}");
        self.set((0x7FE0, 0x0010), Value::Raw("OB", bytes, u32::MAX))
    }

    /// In this coding, pixels too.
    pub(crate) fn coded(mut self, coding: Coding) -> Self {
        let pixels = self.elements.iter_mut().find(|row| row.0.0 == 0x7FE0);
        if let (Coding::Big, Some((_, Value::Raw(_, bytes, _)))) = (coding, pixels) {
            bytes.as_chunks_mut::<2>().0.iter_mut().for_each(|pair| pair.reverse());
        }
        self.coding = coding;
        self.syntax = match coding {
            Coding::Implicit => "1.2.840.10008.1.2",
            Coding::Explicit => "1.2.840.10008.1.2.1",
            Coding::Big => "1.2.840.10008.1.2.2",
        }
        .to_owned();
        self
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        if self.preamble {
            bytes.resize(128, 0);
            bytes.extend(b"DICM");
            let uid = Value::Text("UI", self.syntax.clone());
            element(&mut bytes, Coding::Explicit, (0x0002, 0x0010), &uid);
        }
        for (tag, value) in &self.elements {
            element(&mut bytes, self.coding, *tag, value);
        }
        bytes
    }
}

/// An item of defined length, made even.
pub(crate) fn item(content: &[u8]) -> Vec<u8> {
    let even = content.len().next_multiple_of(2);
    let mut bytes = vec![0xFE, 0xFF, 0x00, 0xE0];
    bytes.extend((even as u32).to_le_bytes());
    bytes.extend(content);
    bytes.resize(8 + even, 0);
    bytes
}

fn element(out: &mut Vec<u8>, coding: Coding, (group, number): (u16, u16), value: &Value) {
    let big = coding == Coding::Big;
    let u16_bytes = |v: u16| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let u32_bytes = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let (vr, bytes, length) = match value {
        Value::Text(vr, text) => {
            let mut bytes = text.clone().into_bytes();
            if bytes.len() % 2 == 1 {
                bytes.push(if *vr == "UI" { 0 } else { b' ' });
            }
            let length = bytes.len() as u32;
            (*vr, bytes, length)
        }
        Value::Us(number) => ("US", u16_bytes(*number).to_vec(), 2),
        Value::Raw(vr, bytes, length) => (*vr, bytes.clone(), *length),
        Value::Items(items, open) => {
            let bytes = sequence(coding, items, *open);
            let length = if *open { u32::MAX } else { bytes.len() as u32 };
            ("SQ", bytes, length)
        }
    };
    out.extend(u16_bytes(group));
    out.extend(u16_bytes(number));
    let long = ["OB", "OV", "OW", "SQ", "UN", "UT"].contains(&vr);
    match (coding, long) {
        (Coding::Implicit, _) => out.extend(u32_bytes(length)),
        (_, true) => {
            out.extend(vr.as_bytes());
            out.extend([0, 0]);
            out.extend(u32_bytes(length));
        }
        (_, false) => {
            out.extend(vr.as_bytes());
            out.extend(u16_bytes(length as u16));
        }
    }
    out.extend(bytes);
}

/// What stands in a sequence: its items, and the delimiter of an open one.
pub(crate) fn sequence(coding: Coding, items: &[Vec<((u16, u16), Value)>], open: bool) -> Vec<u8> {
    let big = coding == Coding::Big;
    let u32_bytes = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let mark = |out: &mut Vec<u8>, number: u16, length: u32| {
        for half in [0xFFFE, number] {
            out.extend(if big {
                u16::to_be_bytes(half)
            } else {
                u16::to_le_bytes(half)
            });
        }
        out.extend(u32_bytes(length));
    };
    let mut out = Vec::new();
    for item in items {
        let mut content = Vec::new();
        item.iter()
            .for_each(|(tag, value)| element(&mut content, coding, *tag, value));
        mark(&mut out, 0xE000, if open { u32::MAX } else { content.len() as u32 });
        out.extend(content);
        if open {
            mark(&mut out, 0xE00D, 0);
        }
    }
    if open {
        mark(&mut out, 0xE0DD, 0);
    }
    out
}
