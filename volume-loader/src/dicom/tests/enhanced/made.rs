//! Enhanced CT files made by hand: the pixels and places of [`stack`](super::stack).

use super::*;

pub(super) type Tag = (u16, u16);
pub(super) const SHARED: Tag = (0x5200, 0x9229);
pub(super) const PER_FRAME: Tag = (0x5200, 0x9230);
pub(super) const POSITION_GROUP: Tag = (0x0020, 0x9113);
pub(super) const ORIENTATION_GROUP: Tag = (0x0020, 0x9116);
pub(super) const MEASURES_GROUP: Tag = (0x0028, 0x9110);
pub(super) const TRANSFORMATION: Tag = (0x0028, 0x9145);
pub(super) const CONTENT_GROUP: Tag = (0x0020, 0x9111);
pub(super) const FRAME_TYPE_GROUP: Tag = (0x0018, 0x9329);

pub(super) type Values = Vec<(Tag, Value)>;

pub(super) fn text(tag: Tag, vr: &'static str, text: &str) -> Values {
    vec![(tag, Value::Text(vr, text.to_owned()))]
}

pub(super) fn transformation(slope: &str, intercept: &str) -> Values {
    let mut values = text((0x0028, 0x1052), "DS", intercept);
    values.extend(text((0x0028, 0x1053), "DS", slope));
    values.extend(text((0x0028, 0x1054), "LO", "HU"));
    values
}

/// What one frame says of itself.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub elements: Values,
    pub pixels: Vec<u16>,
}

impl Frame {
    /// Puts one functional group into it, or another one in its place.
    pub(super) fn group(&mut self, tag: Tag, values: Values) -> &mut Self {
        self.elements.retain(|row| row.0 != tag);
        self.elements.push((tag, Value::Items(vec![values], false)));
        self
    }

    pub(super) fn place(&mut self, [x, y, z]: [f64; 3]) {
        self.group(POSITION_GROUP, text((0x0020, 0x0032), "DS", &format!("{x}\\{y}\\{z}")));
    }

    /// Stack, number in it, temporal position.
    pub(super) fn content(&mut self, stack: &str, numbers: [u32; 2]) -> &mut Self {
        let number = |n: u32| n.to_le_bytes().to_vec();
        let mut values = text((0x0020, 0x9056), "SH", stack);
        values.push(((0x0020, 0x9057), Value::Raw("UL", number(numbers[0]), 4)));
        values.push(((0x0020, 0x9128), Value::Raw("UL", number(numbers[1]), 4)));
        self.group(CONTENT_GROUP, values)
    }
}

/// One file of several frames.
#[derive(Debug, Clone)]
pub(super) struct Enhanced {
    pub coding: Coding,
    /// Whether delimiters end the sequences.
    pub open: bool,
    pub class: &'static str,
    /// What it says outside of functional groups.
    pub base: File,
    pub shared: Values,
    pub frames: Vec<Frame>,
    /// In the place of the frames' own pixels.
    pub pixels: Option<Value>,
    /// NumberOfFrames, where it is not their number.
    pub count: Option<String>,
}

impl Enhanced {
    /// The slices of `stack(count)`.
    pub(super) fn of(count: usize) -> Self {
        let mut base = File::slice(0, 0.0);
        for tag in [
            (0x0018, 0x0050),
            (0x0020, 0x0032),
            (0x0020, 0x0037),
            (0x0028, 0x0030),
            (0x0028, 0x1052),
            (0x0028, 0x1053),
        ] {
            base.remove(tag);
        }
        base.text((0x0008, 0x0018), "UI", "1.2.3.4.7");
        let group = |tag, values| (tag, Value::Items(vec![values], false));
        let frame = |k: usize| {
            let mut frame = Frame {
                elements: Vec::new(),
                pixels: (0..SIZE[0] * SIZE[1]).map(|i| 100 * k as u16 + i).collect(),
            };
            frame.place([-10.0, 20.0, 2.5 * k as f64]);
            frame
        };
        Self {
            coding: Coding::Explicit,
            open: false,
            class: "1.2.840.10008.5.1.4.1.1.2.1",
            base,
            shared: vec![
                group(ORIENTATION_GROUP, text((0x0020, 0x0037), "DS", "1\\0\\0\\0\\1\\0")),
                group(MEASURES_GROUP, text((0x0028, 0x0030), "DS", "0.75\\0.5")),
                group(TRANSFORMATION, transformation("1", "-1024")),
            ],
            frames: (0..count).map(frame).collect(),
            pixels: None,
            count: None,
        }
    }

    pub(super) fn shared_group(&mut self, tag: Tag, values: Values) {
        self.take_shared(tag);
        self.shared.push((tag, Value::Items(vec![values], false)));
    }

    pub(super) fn take_shared(&mut self, tag: Tag) -> Option<Value> {
        let at = self.shared.iter().position(|row| row.0 == tag)?;
        Some(self.shared.remove(at).1)
    }

    pub(super) fn file(&self) -> File {
        let mut file = self.base.clone();
        let count = self.count.clone().unwrap_or(self.frames.len().to_string());
        file.text((0x0008, 0x0016), "UI", self.class)
            .text((0x0028, 0x0008), "IS", &count);
        let items = |items: Vec<Values>| Value::Items(items.iter().map(|item| self.opened(item)).collect(), self.open);
        file.set(SHARED, items(vec![self.shared.clone()]));
        file.set(
            PER_FRAME,
            items(self.frames.iter().map(|frame| frame.elements.clone()).collect()),
        );
        let pixels: Vec<u16> = self.frames.iter().flat_map(|frame| frame.pixels.clone()).collect();
        match &self.pixels {
            Some(value) => file.set((0x7FE0, 0x0010), value.clone()),
            None => file.pixels(&pixels),
        };
        match self.coding {
            Coding::Explicit => file,
            coding => file.coded(coding),
        }
    }

    fn opened(&self, values: &Values) -> Values {
        let mut values: Values = values
            .iter()
            .map(|(tag, value)| match value {
                Value::Items(items, _) => (*tag, Value::Items(items.clone(), self.open)),
                other => (*tag, other.clone()),
            })
            .collect();
        values.sort_by_key(|row| row.0);
        values
    }

    pub(super) fn folder(&self) -> Folder {
        let folder = Folder::new();
        folder.put("many.dcm", &self.file().bytes());
        folder
    }

    /// Why each of its series is refused.
    pub(super) fn refused_parts(&self) -> Vec<String> {
        let folder = self.folder();
        let found = Series::scan(folder.path()).unwrap();
        let opened = found
            .series
            .iter()
            .map(|series| DicomSource::open(series, Options::default()));
        let refused = |one: Result<DicomSource, DicomError>| {
            let text = one.map(|_| ()).unwrap_err().to_string();
            text.replace(&folder.path().display().to_string(), "")
        };
        opened.map(refused).collect()
    }
}
