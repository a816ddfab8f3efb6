//! Which window is the run's, and where on the screen it and its cell lie.

use x11rb::connection::RequestConnection;
use x11rb::cookie::Cookie;
use x11rb::errors::ConnectionError;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt, GetPropertyReply, MapState, Window};

use super::error::ScreenError;
use super::judge::Life;
use super::screen::{Area, Screen, refused};
use crate::code::Place;

/// Window managers nest two or three deep.
const DEEPEST: usize = 5;
/// More windows than that on one screen are looked at in vain.
const MOST: usize = 4096;

/// The run's window as it stands on the screen now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) window: Window,
    pub(super) place: Place,
    /// Where the window lies.
    pub(super) area: Area,
    /// Where its cell lies; `None` where the window says a place outside of itself.
    pub(super) cell: Option<Area>,
}

impl Found {
    pub(super) fn life(&self) -> Life {
        [self.window, self.place.pid]
    }
}

/// The window of the run with this key that is shown: the one known from before, or the uppermost that there is.
///
/// # Errors
/// [`ScreenError::Lost`].
pub(super) fn find(screen: &Screen, known: Option<Window>, key: u32) -> Result<Option<Found>, ScreenError> {
    if let Some(window) = known
        && let Some(found) = look_at(screen, window, key)?
    {
        return Ok(Some(found));
    }
    for window in candidates(screen, key)? {
        if let Some(found) = look_at(screen, window, key)? {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// One window, if it is the run's and shown. The four questions go out together.
fn look_at(screen: &Screen, window: Window, key: u32) -> Result<Option<Found>, ScreenError> {
    let connection = &screen.connection;
    let property = ask(screen, window)?;
    let attributes = connection.get_window_attributes(window)?;
    let geometry = connection.get_geometry(window)?;
    let corner = connection.translate_coordinates(window, screen.root, 0, 0)?;
    let answers = (
        refused(property.reply())?,
        refused(attributes.reply())?,
        refused(geometry.reply())?,
        refused(corner.reply())?,
    );
    let (Some(property), Some(attributes), Some(geometry), Some(corner)) = answers else {
        return Ok(None);
    };
    let Some(place) = place(&property).filter(|place| place.key == key) else {
        return Ok(None);
    };
    if attributes.map_state != MapState::VIEWABLE {
        return Ok(None);
    }
    let area = Area {
        x: corner.dst_x.into(),
        y: corner.dst_y.into(),
        width: geometry.width.into(),
        height: geometry.height.into(),
    };
    let cell = cell(place, area);
    Ok(Some(Found {
        window,
        place,
        area,
        cell,
    }))
}

/// The cell on the screen; `None` where not all of it lies in its window.
fn cell(place: Place, area: Area) -> Option<Area> {
    let [x, y] = place.at.map(|at| i32::try_from(at).ok());
    let [width, height] = place.size();
    let cell = Area {
        x: area.x.checked_add(x?)?,
        y: area.y.checked_add(y?)?,
        width,
        height,
    };
    (cell.within(area) == Some(cell)).then_some(cell)
}

fn ask<'c>(
    screen: &'c Screen,
    window: Window,
) -> Result<Cookie<'c, impl RequestConnection + use<>, GetPropertyReply>, ConnectionError> {
    // One number more than there are, so that a longer list is seen to be longer.
    screen
        .connection
        .get_property(false, window, screen.property, AtomEnum::CARDINAL, 0, 9)
}

fn place(property: &GetPropertyReply) -> Option<Place> {
    let cardinals: Vec<u32> = property.value32()?.collect();
    Place::of_cardinals(&cardinals).ok()
}

/// All windows with a property of this run, the uppermost first, found level by level from the root.
fn candidates(screen: &Screen, key: u32) -> Result<Vec<Window>, ScreenError> {
    let (mut level, mut found, mut seen) = (vec![screen.root], Vec::new(), 0);
    for _ in 0..DEEPEST {
        let below = children(screen, &level)?;
        seen += below.len();
        if below.is_empty() || seen > MOST {
            break;
        }
        let asked: Vec<_> = below
            .iter()
            .map(|window| Ok((*window, ask(screen, *window)?)))
            .collect::<Result<_, ScreenError>>()?;
        for (window, cookie) in asked {
            let property = refused(cookie.reply())?;
            let is_ours = property.as_ref().and_then(place).is_some_and(|place| place.key == key);
            found.extend(is_ours.then_some(window));
        }
        level = below;
    }
    Ok(found)
}

/// The windows right below these, of each the uppermost first.
fn children(screen: &Screen, level: &[Window]) -> Result<Vec<Window>, ScreenError> {
    let asked: Vec<_> = level
        .iter()
        .map(|window| screen.connection.query_tree(*window))
        .collect::<Result<_, _>>()?;
    let mut below = Vec::new();
    for cookie in asked {
        if let Some(tree) = refused(cookie.reply())? {
            below.extend(tree.children.into_iter().rev());
        }
    }
    Ok(below)
}
