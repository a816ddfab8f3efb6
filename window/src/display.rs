//! The screen of an X server: one window that fills it, pixels out, keys and touches in.

mod error;
mod keys;
mod memory;
mod open;

use std::sync::Arc;

use x11rb::connection::Connection;
use x11rb::protocol::Event as XEvent;
use x11rb::protocol::shm::ConnectionExt as _;
use x11rb::protocol::xproto::{ConnectionExt as _, ImageFormat};
use x11rb::rust_connection::RustConnection;

use crate::code::Place;
use crate::sizes::Screen;
#[cfg(test)]
pub(crate) use keys::is_reached;
use keys::{Keyboard, Released};
use memory::Shared;

pub use error::DisplayError;
pub use open::Wanted;

/// The most bytes of pixels in one request, where there is no shared memory.
const MOST_BYTES: usize = 128 * 1024;

/// A rectangle of pixels: left, top, columns, rows.
pub type Part = [u32; 4];

/// What a person or the display did.
#[derive(Debug, Clone, PartialEq)]
pub enum Happened {
    /// A key, a pointer: as egui wants it.
    Input(egui::Event),
    /// What was painted is gone and is to be sent again.
    Exposed,
    /// The window has so many columns and rows now.
    Resized([u32; 2]),
}

/// A window on an X server.
#[derive(Debug)]
pub struct Display {
    connection: Arc<RustConnection>,
    window: u32,
    gc: u32,
    depth: u8,
    screen: Screen,
    keyboard: Keyboard,
    released: Released,
    code_property: u32,
    pixels: Pixels,
}

/// The pixels of the window: shared with the server where it can, else sent.
#[derive(Debug)]
enum Pixels {
    Shared { memory: Shared, segment: u32 },
    Sent(Vec<u32>),
}

impl Display {
    /// The connection, to be waited for.
    pub fn connection(&self) -> Arc<RustConnection> {
        Arc::clone(&self.connection)
    }

    /// Columns and rows of the window, and the size of a pixel.
    pub fn screen(&self) -> Screen {
        self.screen
    }

    /// Whether pixels lie in memory that the server reads itself.
    pub fn is_shared(&self) -> bool {
        matches!(self.pixels, Pixels::Shared { .. })
    }

    /// The pixels, 0x00RRGGBB, row by row from the top.
    pub fn pixels(&mut self) -> &mut [u32] {
        match &mut self.pixels {
            Pixels::Shared { memory, .. } => memory.pixels(),
            Pixels::Sent(pixels) => pixels,
        }
    }

    /// Says where the coded cell lies, for whoever reads it back off the screen.
    ///
    /// # Errors
    /// [`DisplayError::Lost`].
    pub fn set_place(&self, place: Place) -> Result<(), DisplayError> {
        use x11rb::protocol::xproto::{AtomEnum, PropMode};
        use x11rb::wrapper::ConnectionExt as _;
        let (window, property) = (self.window, self.code_property);
        let numbers = place.to_cardinals();
        self.connection
            .change_property32(PropMode::REPLACE, window, property, AtomEnum::CARDINAL, &numbers)?;
        Ok(())
    }

    /// Shows these parts of the pixels, and waits until the server has taken them: only then may they be painted over.
    ///
    /// # Errors
    /// [`DisplayError::Lost`].
    pub fn present(&self, parts: &[Part]) -> Result<(), DisplayError> {
        for part in parts {
            match &self.pixels {
                Pixels::Shared { segment, .. } => self.put_shared(*segment, *part)?,
                Pixels::Sent(pixels) => self.put_sent(pixels, *part)?,
            }
        }
        // The reply comes when everything before it was done.
        self.connection.get_input_focus()?.reply()?;
        Ok(())
    }

    fn put_shared(&self, segment: u32, [x, y, width, height]: Part) -> Result<(), DisplayError> {
        let [columns, rows] = self.screen.pixels.map(|n| n as u16);
        let [left, top, width, height] = [x, y, width, height].map(|n| n as u16);
        let format = u8::from(ImageFormat::Z_PIXMAP);
        self.connection.shm_put_image(
            self.window,
            self.gc,
            columns,
            rows,
            left,
            top,
            width,
            height,
            left as i16,
            top as i16,
            self.depth,
            format,
            false,
            segment,
            0,
        )?;
        Ok(())
    }

    /// In bands of rows, as a request is limited.
    fn put_sent(&self, pixels: &[u32], [x, y, width, height]: Part) -> Result<(), DisplayError> {
        let columns = self.screen.pixels[0] as usize;
        let most = (MOST_BYTES / (4 * width.max(1) as usize)).max(1) as u32;
        for top in (y..y + height).step_by(most as usize) {
            let rows = most.min(y + height - top);
            let band = top..top + rows;
            let row = |row: u32| {
                let from = row as usize * columns + x as usize;
                &pixels[from..from + width as usize]
            };
            let bytes: Vec<u8> = band.flat_map(row).flat_map(|pixel| pixel.to_le_bytes()).collect();
            let (x, top) = (x as i16, top as i16);
            let format = ImageFormat::Z_PIXMAP;
            self.connection.put_image(
                format,
                self.window,
                self.gc,
                width as u16,
                rows as u16,
                x,
                top,
                0,
                self.depth,
                &bytes,
            )?;
        }
        Ok(())
    }

    /// What has happened since the last call.
    ///
    /// # Errors
    /// [`DisplayError::Lost`].
    pub fn happened(&mut self) -> Result<Vec<Happened>, DisplayError> {
        let mut events = Vec::new();
        while let Some(event) = self.connection.poll_for_event()? {
            events.push(event);
        }
        let mut happened = Vec::new();
        for event in keys::without_repeats(events, &mut self.released) {
            match event {
                XEvent::Expose(_) => happened.push(Happened::Exposed),
                XEvent::ConfigureNotify(event) if event.window == self.window => {
                    let size = [u32::from(event.width), u32::from(event.height)];
                    if size != self.screen.pixels {
                        self.resize(size)?;
                        happened.push(Happened::Resized(size));
                    }
                }
                XEvent::MappingNotify(_) => self.keyboard = Keyboard::of(&self.connection)?,
                other => happened.extend(self.keyboard.input(&other).into_iter().map(Happened::Input)),
            }
        }
        Ok(happened)
    }

    fn resize(&mut self, size: [u32; 2]) -> Result<(), DisplayError> {
        if let Pixels::Shared { segment, .. } = &self.pixels {
            self.connection.shm_detach(*segment)?;
        }
        self.screen.pixels = size;
        self.pixels = open::pixels(&self.connection, size)?;
        Ok(())
    }
}
