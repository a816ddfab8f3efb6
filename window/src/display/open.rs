//! Opening a window on an X server, or saying why there is none.

use std::sync::Arc;

use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::randr::ConnectionExt as _;
use x11rb::protocol::shm::{self, ConnectionExt as _};
use x11rb::protocol::xproto::{
    AtomEnum, ConnectionExt as _, CreateGCAux, CreateWindowAux, EventMask, PropMode, Screen as XScreen, VisualClass,
    WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

use super::error::DisplayError;
use super::keys::Keyboard;
use super::memory::Shared;
use super::{Display, Pixels};
use crate::sizes::Screen;

/// Of a monitor that does not say how large it is: 96 pixels an inch.
const USUAL_PIXEL_MM: f32 = 25.4 / 96.0;
/// A pixel smaller or larger than this is a monitor that does not know its size.
const PIXEL_MM: std::ops::RangeInclusive<f32> = 0.05..=1.5;

/// The window that is wanted.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Columns and rows; `None` fills the screen.
    pub size: Option<[u32; 2]>,
    /// Width of the monitor's picture, mm; `None` asks the display.
    pub monitor_mm: Option<f32>,
    /// What stands in its frame.
    pub title: String,
}

impl Display {
    /// Opens a window on the display that `DISPLAY` names.
    ///
    /// # Errors
    /// Each variant of [`DisplayError`].
    pub fn open(wanted: &Wanted) -> Result<Self, DisplayError> {
        let Some(display) = std::env::var_os("DISPLAY").filter(|display| !display.is_empty()) else {
            return Err(DisplayError::None);
        };
        let (connection, number) = RustConnection::connect(None).map_err(|source| DisplayError::Connect {
            display: display.to_string_lossy().into_owned(),
            source,
        })?;
        let root = connection.setup().roots[number].clone();
        check_pixels(&root)?;
        let size = wanted
            .size
            .unwrap_or([root.width_in_pixels, root.height_in_pixels].map(u32::from));
        let pixel_mm = match wanted.monitor_mm {
            Some(mm) => (mm / f32::from(root.width_in_pixels)).clamp(*PIXEL_MM.start(), *PIXEL_MM.end()),
            None => pixel_mm(&connection, &root),
        };
        let window = create(&connection, &root, size, wanted)?;
        let gc = connection.generate_id()?;
        connection.create_gc(gc, window, &CreateGCAux::new().graphics_exposures(0))?;
        let code_property = connection
            .intern_atom(false, crate::code::PROPERTY.as_bytes())?
            .reply()?
            .atom;
        let pixels = pixels(&connection, size)?;
        connection.map_window(window)?;
        connection.flush()?;
        Ok(Self {
            keyboard: Keyboard::of(&connection)?,
            released: None,
            connection: Arc::new(connection),
            window,
            gc,
            depth: root.root_depth,
            screen: Screen { pixels: size, pixel_mm },
            code_property,
            pixels,
        })
    }
}

fn check_pixels(root: &XScreen) -> Result<(), DisplayError> {
    let visuals = || root.allowed_depths.iter().flat_map(|depth| &depth.visuals);
    let own = visuals().find(|visual| visual.visual_id == root.root_visual);
    let masks = own.map(|visual| [visual.red_mask, visual.green_mask, visual.blue_mask]);
    let is_true = own.is_some_and(|visual| visual.class == VisualClass::TRUE_COLOR);
    match masks == Some([0xff_0000, 0xff00, 0xff]) && is_true && matches!(root.root_depth, 24 | 32) {
        true => Ok(()),
        false => Err(DisplayError::Depth { depth: root.root_depth }),
    }
}

/// The side of a pixel: of the first monitor that says its size, else of the screen, else the usual.
fn pixel_mm(connection: &RustConnection, root: &XScreen) -> f32 {
    let monitors = connection
        .randr_get_monitors(root.root, true)
        .ok()
        .and_then(|cookie| cookie.reply().ok());
    let sizes = monitors.into_iter().flat_map(|reply| reply.monitors);
    let monitors = sizes.map(|monitor| monitor.width_in_millimeters as f32 / f32::from(monitor.width));
    let screen = f32::from(root.width_in_millimeters) / f32::from(root.width_in_pixels);
    let mut said = monitors.chain([screen]);
    said.find(|mm| PIXEL_MM.contains(mm)).unwrap_or(USUAL_PIXEL_MM)
}

fn create(connection: &RustConnection, root: &XScreen, size: [u32; 2], wanted: &Wanted) -> Result<u32, DisplayError> {
    let window = connection.generate_id()?;
    let events = EventMask::EXPOSURE
        | EventMask::STRUCTURE_NOTIFY
        | EventMask::KEY_PRESS
        | EventMask::KEY_RELEASE
        | EventMask::BUTTON_PRESS
        | EventMask::BUTTON_RELEASE
        | EventMask::POINTER_MOTION
        | EventMask::LEAVE_WINDOW;
    let how = CreateWindowAux::new()
        .event_mask(events)
        .background_pixel(root.black_pixel);
    let [width, height] = size.map(|n| n.clamp(1, 32_767) as u16);
    let (depth, class) = (x11rb::COPY_DEPTH_FROM_PARENT, WindowClass::INPUT_OUTPUT);
    connection.create_window(
        depth,
        window,
        root.root,
        0,
        0,
        width,
        height,
        0,
        class,
        root.root_visual,
        &how,
    )?;
    let replace = PropMode::REPLACE;
    connection.change_property8(
        replace,
        window,
        AtomEnum::WM_NAME,
        AtomEnum::STRING,
        wanted.title.as_bytes(),
    )?;
    connection.change_property8(
        replace,
        window,
        AtomEnum::WM_CLASS,
        AtomEnum::STRING,
        b"trocar\0trocar\0",
    )?;
    if wanted.size.is_none() {
        let atom = |name: &str| Ok::<u32, DisplayError>(connection.intern_atom(false, name.as_bytes())?.reply()?.atom);
        let (state, full) = (atom("_NET_WM_STATE")?, atom("_NET_WM_STATE_FULLSCREEN")?);
        connection.change_property32(replace, window, state, AtomEnum::ATOM, &[full])?;
    }
    Ok(window)
}

/// Memory for a window of this size: shared with the server, or of this process alone where the server cannot.
pub(super) fn pixels(connection: &RustConnection, [width, height]: [u32; 2]) -> Result<Pixels, DisplayError> {
    let count = width as usize * height as usize;
    if !can_share(connection) {
        return Ok(Pixels::Sent(vec![0; count]));
    }
    let (memory, file) = Shared::new(count)?;
    let segment = connection.generate_id()?;
    let attached = connection.shm_attach_fd(segment, file, true)?.check();
    match attached {
        Ok(()) => Ok(Pixels::Shared { memory, segment }),
        // A server on another machine, or one that may not read this process's memory.
        Err(_) => Ok(Pixels::Sent(vec![0; count])),
    }
}

fn can_share(connection: &RustConnection) -> bool {
    let has = connection
        .extension_information(shm::X11_EXTENSION_NAME)
        .ok()
        .flatten()
        .is_some();
    // Memory by its descriptor came with 1.2.
    let version = || connection.shm_query_version().ok()?.reply().ok();
    has && version().is_some_and(|version| (version.major_version, version.minor_version) >= (1, 2))
}
