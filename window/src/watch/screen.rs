//! The connection to an X server: its root, the layout of its pixels, and what stands on a part of it.

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{Atom, ConnectionExt, ImageFormat, Window};
use x11rb::rust_connection::RustConnection;

use super::error::ScreenError;
use super::pixels::Layout;
use super::stream::{Patient, connect};
use crate::code::PROPERTY;

/// A part of the screen: its upper left corner from the root's, and its size, pixels. The corner may lie beyond the root.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Area {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Area {
    /// One pixel behind the right and the lower edge.
    pub(super) fn end(self) -> [i64; 2] {
        [
            i64::from(self.x) + i64::from(self.width),
            i64::from(self.y) + i64::from(self.height),
        ]
    }

    /// The part that lies in `other` too; `None` where there is none.
    pub(super) fn within(self, other: Self) -> Option<Self> {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let [a, b] = [self.end(), other.end()];
        let side = |end: i64, begin: i32| u32::try_from(end - i64::from(begin)).ok().filter(|side| *side > 0);
        let (width, height) = (side(a[0].min(b[0]), x)?, side(a[1].min(b[1]), y)?);
        Some(Self { x, y, width, height })
    }
}

/// A connection.
pub(super) struct Screen {
    pub(super) connection: RustConnection<Patient>,
    pub(super) root: Window,
    /// The whole root, as large as it was when it was measured last.
    pub(super) whole: Area,
    pub(super) depth: u8,
    pub(super) layout: Layout,
    /// The property by which windows say where their cell lies.
    pub(super) property: Atom,
}

impl Screen {
    /// Connects to `display`.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn open(display: &str) -> Result<Self, ScreenError> {
        let (connection, number) = connect(display)?;
        let setup = connection.setup();
        // `connect` has refused a screen that there is not.
        let found = setup.roots.get(number).ok_or(ScreenError::Pixels)?;
        let visuals = found.allowed_depths.iter().flat_map(|depth| &depth.visuals);
        let visual = visuals.into_iter().find(|visual| visual.visual_id == found.root_visual);
        let layout = visual.and_then(|visual| Layout::of(setup, found.root_depth, visual));
        let (root, depth) = (found.root, found.root_depth);
        let layout = layout.ok_or(ScreenError::Pixels)?;
        let property = connection.intern_atom(false, PROPERTY.as_bytes())?.reply()?.atom;
        let whole = measured(&connection, root)?;
        Ok(Self {
            connection,
            root,
            whole,
            depth,
            layout,
            property,
        })
    }

    /// Measures the root anew: monitors come and go.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn measure(&mut self) -> Result<(), ScreenError> {
        self.whole = measured(&self.connection, self.root)?;
        Ok(())
    }

    /// The pixels of the screen there, whoever painted them, 4 bytes each; `None` where not all of `area` lies on the screen.
    ///
    /// # Errors
    /// [`ScreenError::Lost`].
    pub(super) fn pixels(&self, area: Area) -> Result<Option<Vec<u8>>, ScreenError> {
        let is_whole = area.within(self.whole) == Some(area);
        let corner = (i16::try_from(area.x), i16::try_from(area.y));
        let size = (u16::try_from(area.width), u16::try_from(area.height));
        let ((Ok(x), Ok(y)), (Ok(width), Ok(height)), true) = (corner, size, is_whole) else {
            return Ok(None);
        };
        let format = ImageFormat::Z_PIXMAP;
        let cookie = self
            .connection
            .get_image(format, self.root, x, y, width, height, u32::MAX)?;
        // A screen that has just become smaller makes this fail.
        let Some(image) = refused(cookie.reply())? else {
            return Ok(None);
        };
        let size = [width.into(), height.into()];
        Ok(self
            .layout
            .decode(&image.data, size)
            .filter(|_| image.depth == self.depth))
    }
}

fn measured(connection: &RustConnection<Patient>, root: Window) -> Result<Area, ScreenError> {
    let size = connection.get_geometry(root)?.reply()?;
    Ok(Area {
        x: 0,
        y: 0,
        width: size.width.into(),
        height: size.height.into(),
    })
}

/// `None` for a request that the server refused: windows vanish at any time, and what is asked of them then is an error to it.
///
/// # Errors
/// [`ScreenError::Lost`].
pub(super) fn refused<T>(reply: Result<T, x11rb::errors::ReplyError>) -> Result<Option<T>, ScreenError> {
    match reply {
        Ok(reply) => Ok(Some(reply)),
        Err(x11rb::errors::ReplyError::X11Error(_)) => Ok(None),
        Err(x11rb::errors::ReplyError::ConnectionError(lost)) => Err(lost.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(x: i32, y: i32, width: u32, height: u32) -> Area {
        Area { x, y, width, height }
    }

    #[test]
    fn parts_are_cut_at_the_edges() {
        let whole = area(0, 0, 100, 50);
        assert_eq!(area(-10, 40, 30, 30).within(whole), Some(area(0, 40, 20, 10)));
        assert_eq!(area(100, 0, 5, 5).within(whole), None);
        assert_eq!(area(i32::MAX, 0, u32::MAX, 5).within(whole), None);
        assert_eq!(whole.within(area(i32::MIN, i32::MIN, u32::MAX, u32::MAX)), Some(whole));
    }
}
