//! The red cover: a window above all others, with a hole where the cell lies.
//!
//! The hole is what lifts it again: the cell stays on the screen, so whether the window lives is read off the same pixels as before.

use picture::palette;
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::randr::ConnectionExt as _;
use x11rb::protocol::shape::{self, ConnectionExt as _};
use x11rb::protocol::xproto::{
    AtomEnum, ClipOrdering, ConfigureWindowAux, ConnectionExt as _, CreateGCAux, CreateWindowAux, EventMask, Gcontext,
    ImageFormat, PropMode, Rectangle, StackMode, Window, WindowClass,
};
use x11rb::wrapper::ConnectionExt as _;

use super::drawing::{PIXEL_MM, draw};
use super::error::ScreenError;
use super::screen::{Area, Screen, refused};

/// What the window is called, for those who list windows.
const NAME: &str = "trocar window-watch";
/// A request without its pixels, bytes, and a little more.
const HEAD: usize = 64;
/// Pixels of screens; what is said beyond is no size.
const PIXELS_MM: std::ops::RangeInclusive<f64> = 0.05..=1.5;

/// What is covered: an area, but for the hole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Extent {
    pub(super) area: Area,
    pub(super) hole: Option<Area>,
}

/// The cover as it stands on the screen.
#[derive(Debug)]
pub(super) struct Cover {
    window: Window,
    graphics: Gcontext,
    extent: Extent,
    pixel_mm: f64,
    /// How high the words were that stand there now, pixels.
    band: Option<u32>,
}

impl Cover {
    /// Puts a cover up. It is red at once, and has words with the first [`Cover::say`].
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn put_up(screen: &Screen, extent: Extent) -> Result<Self, ScreenError> {
        let connection = &screen.connection;
        let (window, graphics) = (connection.generate_id()?, connection.generate_id()?);
        let red = screen
            .layout
            .pixel([palette::ALARM.0, palette::ALARM.1, palette::ALARM.2]);
        let values = CreateWindowAux::new()
            .override_redirect(1)
            .background_pixel(red)
            .border_pixel(red)
            .event_mask(EventMask::VISIBILITY_CHANGE | EventMask::EXPOSURE);
        let ([x, y], [width, height]) = (corner(extent.area), size(extent.area));
        let class = WindowClass::INPUT_OUTPUT;
        connection.create_window(0, window, screen.root, x, y, width, height, 0, class, 0, &values)?;
        connection.create_gc(graphics, window, &CreateGCAux::new())?;
        connection.change_property8(
            PropMode::REPLACE,
            window,
            AtomEnum::WM_NAME,
            AtomEnum::STRING,
            NAME.as_bytes(),
        )?;
        let mut cover = Self {
            window,
            graphics,
            extent,
            pixel_mm: PIXEL_MM,
            band: None,
        };
        cover.cut(screen)?;
        connection.map_window(window)?;
        connection.flush()?;
        // Asked when the red is on its way: nothing waits for the size of a monitor.
        if let Some(found) = pixel_mm(screen, extent.area)? {
            cover.pixel_mm = found;
        }
        Ok(cover)
    }

    /// Covers this extent from now on.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn move_to(&mut self, screen: &Screen, extent: Extent) -> Result<(), ScreenError> {
        if self.extent == extent {
            return Ok(());
        }
        self.extent = extent;
        let ([x, y], [width, height]) = (corner(extent.area), size(extent.area));
        let place = ConfigureWindowAux::new()
            .x(i32::from(x))
            .y(i32::from(y))
            .width(u32::from(width))
            .height(u32::from(height));
        screen.connection.configure_window(self.window, &place)?;
        self.band = None;
        self.cut(screen)
    }

    /// Puts the cover above whatever has come above it.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn raise(&self, screen: &Screen) -> Result<(), ScreenError> {
        let above = ConfigureWindowAux::new().stack_mode(StackMode::ABOVE);
        screen.connection.configure_window(self.window, &above)?;
        Ok(screen.connection.flush()?)
    }

    /// Writes the words, in the middle of the largest part that the hole leaves.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn say(&mut self, screen: &Screen, headline: &str, reason: &str) -> Result<(), ScreenError> {
        let Some(room) = roomiest(&strips(self.extent)) else {
            return Ok(());
        };
        let canvas = draw([room.width, room.height], self.pixel_mm, headline, reason);
        let connection = &screen.connection;
        if self.band != Some(canvas.height()) {
            connection.clear_area(false, self.window, 0, 0, 0, 0)?;
        }
        self.band = Some(canvas.height());
        let width = canvas.width() as usize;
        let data = screen.layout.encode(canvas.rgba(), width);
        let stride = data.len() / canvas.height().max(1) as usize;
        let rows = ((connection.maximum_request_bytes().saturating_sub(HEAD)) / stride.max(1)).max(1);
        let top = room.y + ((room.height - canvas.height()) / 2) as i32;
        for (i, part) in data.chunks(rows * stride).enumerate() {
            let [x, y] = [room.x, top + (i * rows) as i32].map(short);
            let height = (part.len() / stride) as u16;
            let format = ImageFormat::Z_PIXMAP;
            connection.put_image(
                format,
                self.window,
                self.graphics,
                width as u16,
                height,
                x,
                y,
                0,
                screen.depth,
                part,
            )?;
        }
        Ok(connection.flush()?)
    }

    /// Takes the cover away.
    ///
    /// # Errors
    /// [`ScreenError`].
    pub(super) fn take_down(self, screen: &Screen) -> Result<(), ScreenError> {
        screen.connection.free_gc(self.graphics)?;
        screen.connection.destroy_window(self.window)?;
        Ok(screen.connection.flush()?)
    }

    /// Cuts the hole. A server that has no windows with holes gets a cover that leaves a whole strip free.
    fn cut(&mut self, screen: &Screen) -> Result<(), ScreenError> {
        let strips: Vec<Rectangle> = strips(self.extent).iter().map(|strip| rectangle(*strip)).collect();
        let (set, kind, order) = (shape::SO::SET, shape::SK::BOUNDING, ClipOrdering::UNSORTED);
        let connection = &screen.connection;
        // Asked by its name: what is requested of an extension that is not there breaks nothing but this request.
        match connection.shape_rectangles(set, kind, order, self.window, 0, 0, &strips) {
            Ok(cookie) => cookie.ignore_error(),
            Err(x11rb::errors::ConnectionError::UnsupportedExtension) => self.shrink(screen)?,
            Err(lost) => return Err(lost.into()),
        }
        Ok(())
    }

    fn shrink(&mut self, screen: &Screen) -> Result<(), ScreenError> {
        if let (Some(_), Some(room)) = (self.extent.hole, roomiest(&strips(self.extent))) {
            let place = ConfigureWindowAux::new()
                .x(self.extent.area.x + room.x)
                .y(self.extent.area.y + room.y)
                .width(room.width)
                .height(room.height);
            screen.connection.configure_window(self.window, &place)?;
            self.extent = Extent {
                area: Area {
                    x: self.extent.area.x + room.x,
                    y: self.extent.area.y + room.y,
                    ..room
                },
                hole: None,
            };
        }
        Ok(())
    }
}

/// The parts of the area that are not the hole, from the area's own corner: above, below, left and right of it.
fn strips(extent: Extent) -> Vec<Area> {
    let Area { width, height, .. } = extent.area;
    let whole = Area {
        x: 0,
        y: 0,
        width,
        height,
    };
    let hole = extent.hole.and_then(|hole| hole.within(extent.area));
    let Some(hole) = hole else { return vec![whole] };
    // Inside of the area, so from here on nothing is negative.
    let (left, top) = ((hole.x - extent.area.x) as u32, (hole.y - extent.area.y) as u32);
    let (right, bottom) = (left + hole.width, top + hole.height);
    let strip = |x: u32, y: u32, width: u32, height: u32| Area {
        x: x as i32,
        y: y as i32,
        width,
        height,
    };
    let around = [
        strip(0, 0, width, top),
        strip(0, bottom, width, height - bottom),
        strip(0, top, left, hole.height),
        strip(right, top, width - right, hole.height),
    ];
    around
        .into_iter()
        .filter(|strip| strip.width > 0 && strip.height > 0)
        .collect()
}

fn roomiest(strips: &[Area]) -> Option<Area> {
    strips
        .iter()
        .copied()
        .max_by_key(|strip| u64::from(strip.width) * u64::from(strip.height))
}

fn short(at: i32) -> i16 {
    at.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}

fn corner(area: Area) -> [i16; 2] {
    [short(area.x), short(area.y)]
}

fn size(area: Area) -> [u16; 2] {
    [area.width, area.height].map(|side| side.clamp(1, 32_767) as u16)
}

fn rectangle(area: Area) -> Rectangle {
    let ([x, y], [width, height]) = (corner(area), size(area));
    Rectangle { x, y, width, height }
}

/// How large a pixel is on the monitor under the middle of `area`, mm; `None` where nobody says, or nothing credible.
fn pixel_mm(screen: &Screen, area: Area) -> Result<Option<f64>, ScreenError> {
    let cookie = match screen.connection.randr_get_monitors(screen.root, true) {
        Ok(cookie) => cookie,
        Err(x11rb::errors::ConnectionError::UnsupportedExtension) => return Ok(None),
        Err(lost) => return Err(lost.into()),
    };
    let monitors = refused(cookie.reply())?.map(|reply| reply.monitors).unwrap_or_default();
    let middle = Area {
        x: area.x.saturating_add((area.width / 2) as i32),
        y: area.y.saturating_add((area.height / 2) as i32),
        width: 1,
        height: 1,
    };
    let under = monitors.iter().find(|monitor| {
        let whole = Area {
            x: monitor.x.into(),
            y: monitor.y.into(),
            width: monitor.width.into(),
            height: monitor.height.into(),
        };
        middle.within(whole).is_some()
    });
    let size = under.map(|monitor| f64::from(monitor.width_in_millimeters) / f64::from(monitor.width.max(1)));
    Ok(size.filter(|mm| PIXELS_MM.contains(mm)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(x: i32, y: i32, width: u32, height: u32) -> Area {
        Area { x, y, width, height }
    }

    /// Each pixel of the area is covered once, and none of the hole.
    #[test]
    fn all_is_covered_but_the_hole() {
        let whole = area(7, -3, 40, 30);
        for hole in [
            area(7, -3, 9, 5),
            area(30, 2, 17, 4),
            area(40, 20, 50, 50),
            area(12, 3, 5, 5),
            area(900, 0, 5, 5),
        ] {
            let parts = strips(Extent {
                area: whole,
                hole: Some(hole),
            });
            for (x, y) in (0..40).flat_map(|x| (0..30).map(move |y| (x, y))) {
                let covers = parts
                    .iter()
                    .filter(|part| area(x, y, 1, 1).within(**part).is_some())
                    .count();
                let in_hole = area(x + 7, y - 3, 1, 1).within(hole).is_some();
                assert_eq!(covers, usize::from(!in_hole), "({x}, {y}) {hole:?}");
            }
        }
    }
}
