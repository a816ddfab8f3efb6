//! Sequences of any object, item by item: for the objects that are no images of a CT.

use std::io::{BufRead, Seek};

use super::{Elements, starts_with_preamble, starts_without_meta};
use crate::dicom::error::FileError;
use crate::dicom::syntax::{Coding, Syntax};
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::walk::{Element, Open, WalkError, Walker};

/// Sequences that are asked for, within one another; the standard's own objects stay below.
const MAX_DEPTH: usize = 6;
/// What is asked for is numbers, codes and names, and none is longer.
const MAX_VALUE: u32 = 1 << 12;
/// Items of one sequence: a hundred organs in five hundred planes each have fewer frames.
const MAX_ITEMS: u64 = 1 << 16;

/// What is asked for, wherever it stands; all else is passed over.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asked {
    pub values: &'static [Tag],
    /// Those of `values` that are passed over where they are longer than numbers of one place.
    pub long: &'static [Tag],
    pub sequences: &'static [Tag],
}

/// An item: the values and the sequences that were asked for.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub values: Elements,
    sequences: Vec<(Tag, Vec<Tree>)>,
}

impl Tree {
    /// Reads a file up to its pixel data; `each` is given every item of a sequence of the data set itself as it comes, so that no file is
    /// held. `None` where it is no DICOM file.
    ///
    /// # Errors
    /// [`WalkError`], and what `each` refuses.
    pub(crate) fn read<R: BufRead + Seek>(
        walker: &mut Walker<R>,
        asked: &Asked,
        mut each: impl FnMut(Tag, Self) -> Result<(), FileError>,
    ) -> Result<Option<Elements>, WalkError> {
        let mut elements = Elements::default();
        if starts_with_preamble(walker)? {
            elements.read_meta(walker)?;
        } else if !starts_without_meta(walker)? {
            return Ok(None);
        }
        let coding = elements.syntax.elements;
        while walker.position() < walker.length() {
            let element = walker.element(coding)?;
            if element.tag == el::PIXELS {
                elements.pixels = Some(element);
                elements.check_pixels(walker, &element)?;
                break;
            }
            if asked.sequences.contains(&element.tag) {
                let (sequence, mut count) = (walker.open(&element, coding)?, 0);
                while let Some(item) = walker.next_item(&sequence)? {
                    count += 1;
                    if count > MAX_ITEMS {
                        let (tag, found) = (element.tag, format!("more than {MAX_ITEMS}"));
                        let expected = format!("at most {MAX_ITEMS}");
                        return Err(FileError::Items { tag, found, expected }.into());
                    }
                    // A sound file may have a million elements in its items.
                    let item = walker.counted_apart(|walker| Self::item(walker, &item, asked, 1))?;
                    each(element.tag, item)?;
                }
                continue;
            }
            elements.take_asked(walker, &element, coding, asked)?;
        }
        Ok(Some(elements))
    }

    fn item<R: BufRead + Seek>(
        walker: &mut Walker<R>,
        item: &Open,
        asked: &Asked,
        depth: usize,
    ) -> Result<Self, WalkError> {
        let syntax = Syntax {
            elements: item.coding,
            ..Syntax::DEFAULT
        };
        let mut tree = Self::default();
        tree.values.syntax = syntax;
        while let Some(element) = walker.next_in(item)? {
            let Element { tag, byte, .. } = element;
            if !asked.sequences.contains(&tag) {
                tree.values.take_asked(walker, &element, item.coding, asked)?;
                continue;
            }
            if depth == MAX_DEPTH {
                return Err(FileError::Nesting { byte, limit: depth }.into());
            }
            if tree.sequences.iter().any(|row| row.0 == tag) {
                return Err(FileError::Twice { tag, byte }.into());
            }
            let (sequence, mut items) = (walker.open(&element, item.coding)?, Vec::new());
            while let Some(inner) = walker.next_item(&sequence)? {
                items.push(Self::item(walker, &inner, asked, depth + 1)?);
            }
            tree.sequences.push((tag, items));
        }
        Ok(tree)
    }

    /// The items of a sequence; none where it is absent.
    pub(crate) fn items(&self, tag: Tag) -> &[Self] {
        let found = self.sequences.iter().find(|row| row.0 == tag);
        found.map_or(&[], |row| &row.1)
    }

    /// The item of a sequence that has no more than one.
    ///
    /// # Errors
    /// [`FileError::Items`].
    pub(crate) fn only(&self, tag: Tag) -> Result<Option<&Self>, FileError> {
        match self.items(tag) {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            several => Err(FileError::Items {
                tag,
                found: several.len().to_string(),
                expected: "one".to_owned(),
            }),
        }
    }
}

impl Elements {
    /// Keeps the value if it is asked for, and passes over it otherwise. One that is too long is refused: another would be taken for it.
    fn take_asked<R: BufRead + Seek>(
        &mut self,
        walker: &mut Walker<R>,
        element: &Element,
        coding: Coding,
        asked: &Asked,
    ) -> Result<(), WalkError> {
        let Element { tag, byte, .. } = *element;
        let is_long = element.length.is_none_or(|length| length > MAX_VALUE);
        if !asked.values.contains(&tag) || is_long && asked.long.contains(&tag) {
            return walker.skip(element, coding);
        }
        if is_long {
            let (found, limit) = (
                element.length.map_or(u64::from(u32::MAX), u64::from),
                u64::from(MAX_VALUE),
            );
            return Err(FileError::TooLong {
                tag,
                byte,
                found,
                limit,
            }
            .into());
        }
        if self.get(tag).is_some() {
            return Err(FileError::Twice { tag, byte }.into());
        }
        let value = walker.value(element)?;
        self.values.push((tag, value));
        Ok(())
    }
}
