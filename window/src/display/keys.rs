//! Keys, buttons and the pointer, as egui wants them.

use egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, vec2};
use x11rb::connection::Connection;
use x11rb::protocol::Event as XEvent;
use x11rb::protocol::xproto::{ConnectionExt as _, KeyButMask};
use x11rb::rust_connection::RustConnection;

use super::error::DisplayError;

/// Which key bears which sign.
#[derive(Debug)]
pub(super) struct Keyboard {
    first: u8,
    signs_per_key: usize,
    signs: Vec<u32>,
}

/// The keys that the screen knows beside letters and digits, by the X keysym of their first sign.
const KEYS: [(u32, Key); 32] = [
    (0x0020, Key::Space),
    (0x002b, Key::Plus),
    (0x002c, Key::Comma),
    (0x002d, Key::Minus),
    (0x002e, Key::Period),
    (0x003d, Key::Equals),
    (0x005b, Key::OpenBracket),
    (0x005d, Key::CloseBracket),
    (0xffab, Key::Plus),
    (0xffad, Key::Minus),
    (0xff8d, Key::Enter),
    (0xff08, Key::Backspace),
    (0xff0d, Key::Enter),
    (0xff1b, Key::Escape),
    (0xff51, Key::ArrowLeft),
    (0xff52, Key::ArrowUp),
    (0xff53, Key::ArrowRight),
    (0xff54, Key::ArrowDown),
    (0xff55, Key::PageUp),
    (0xff56, Key::PageDown),
    (0xffff, Key::Delete),
    (0xff09, Key::Tab),
    (0xffbe, Key::F1),
    (0xffbf, Key::F2),
    (0xffc0, Key::F3),
    (0xffc1, Key::F4),
    (0xffc2, Key::F5),
    (0xffc3, Key::F6),
    (0xffc4, Key::F7),
    (0xffc5, Key::F8),
    (0xffc6, Key::F9),
    (0xffc7, Key::F10),
];

/// The key with this sign.
fn key_of(sign: u32) -> Option<Key> {
    let known = KEYS.iter().find(|(known, _)| *known == sign).map(|&(_, key)| key);
    known.or_else(|| {
        let sign = char::from_u32(sign).filter(char::is_ascii_alphanumeric)?;
        Key::from_name(&sign.to_ascii_uppercase().to_string())
    })
}

/// Whether some sign is that of this key: what no sign leads to works in tests alone.
#[cfg(test)]
pub(crate) fn is_reached(key: Key) -> bool {
    (0x20..0x10000).any(|sign| key_of(sign) == Some(key))
}

/// The letter of a sign: Latin 1 stands for itself, the rest of Unicode above a million (X11, appendix A).
fn letter_of(sign: u32) -> Option<char> {
    let code = match sign {
        0x20..=0x7e | 0xa0..=0xff => sign,
        0x0100_0100..=0x0110_ffff => sign - 0x0100_0000,
        _ => return None,
    };
    char::from_u32(code).filter(|letter| !letter.is_control())
}

impl Keyboard {
    pub(super) fn of(connection: &RustConnection) -> Result<Self, DisplayError> {
        let (first, last) = (connection.setup().min_keycode, connection.setup().max_keycode);
        let count = last.saturating_sub(first).saturating_add(1);
        let reply = connection.get_keyboard_mapping(first, count)?.reply()?;
        Ok(Self {
            first,
            signs_per_key: usize::from(reply.keysyms_per_keycode).max(1),
            signs: reply.keysyms,
        })
    }

    /// The sign of a key by itself, or with Shift.
    fn sign(&self, code: u8, is_shifted: bool) -> Option<u32> {
        let at = usize::from(code.checked_sub(self.first)?) * self.signs_per_key;
        let signs = self.signs.get(at..at + self.signs_per_key)?;
        let sign = signs.get(usize::from(is_shifted)).copied().filter(|sign| *sign != 0);
        sign.or_else(|| signs.first().copied())
    }

    /// What egui is to be told of an event: the key, and the letter that it types.
    pub(super) fn input(&self, event: &XEvent) -> Vec<Event> {
        let typed = match event {
            XEvent::KeyPress(key) => self.typed(key.detail, key.state),
            _ => None,
        };
        // egui knows of Shift and Ctrl what it is told, and forgets what comes with a key or a button.
        let held = state(event).map(|state| Event::ModifiersChanged(modifiers(state)));
        held.into_iter().chain(self.told(event)).chain(typed).collect()
    }

    fn typed(&self, code: u8, state: KeyButMask) -> Option<Event> {
        let modifiers = modifiers(state);
        let is_command = modifiers.ctrl || modifiers.alt;
        let sign = self.sign(code, modifiers.shift).filter(|_| !is_command)?;
        letter_of(sign).map(|letter| Event::Text(letter.to_string()))
    }

    fn told(&self, event: &XEvent) -> Option<Event> {
        match event {
            XEvent::KeyPress(key) => self.pressed(key.detail, key.state, true),
            XEvent::KeyRelease(key) => self.pressed(key.detail, key.state, false),
            XEvent::ButtonPress(button) => clicked(button.detail, [button.event_x, button.event_y], button.state, true),
            XEvent::ButtonRelease(button) => {
                clicked(button.detail, [button.event_x, button.event_y], button.state, false)
            }
            XEvent::MotionNotify(motion) => Some(Event::PointerMoved(place([motion.event_x, motion.event_y]))),
            XEvent::LeaveNotify(_) => Some(Event::PointerGone),
            _ => None,
        }
    }

    fn key(&self, code: u8, state: KeyButMask) -> Option<Key> {
        let shifted = modifiers(state).shift.then(|| self.sign(code, true)).flatten();
        shifted.and_then(key_of).or_else(|| key_of(self.sign(code, false)?))
    }

    fn pressed(&self, code: u8, state: KeyButMask, pressed: bool) -> Option<Event> {
        Some(Event::Key {
            // The key is what its sign says: + lies on another key, or behind Shift, as the keyboard has it.
            key: self.key(code, state)?,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: modifiers(state),
        })
    }
}

/// Which key came up last, and at which moment of the server's.
pub(super) type Released = Option<(u8, u32)>;

/// A key that is held down comes as a release with a press at the same moment, again and again: it was not pressed again. What is held
/// down marks one moment, and does not hold and follow in turn. The press may come with a later call than its release.
pub(super) fn without_repeats(mut events: Vec<XEvent>, released: &mut Released) -> Vec<XEvent> {
    events.retain(|event| match event {
        XEvent::KeyRelease(up) => {
            *released = Some((up.detail, up.time));
            true
        }
        XEvent::KeyPress(down) => *released != Some((down.detail, down.time)),
        _ => true,
    });
    events
}

fn place([x, y]: [i16; 2]) -> Pos2 {
    Pos2::new(f32::from(x), f32::from(y))
}

fn modifiers(state: KeyButMask) -> Modifiers {
    let has = |mask: KeyButMask| u16::from(state) & u16::from(mask) != 0;
    let ctrl = has(KeyButMask::CONTROL);
    Modifiers {
        alt: has(KeyButMask::MOD1),
        ctrl,
        shift: has(KeyButMask::SHIFT),
        mac_cmd: false,
        command: ctrl,
    }
}

/// What is held down while something happens.
fn state(event: &XEvent) -> Option<KeyButMask> {
    match event {
        XEvent::KeyPress(key) | XEvent::KeyRelease(key) => Some(key.state),
        XEvent::ButtonPress(button) | XEvent::ButtonRelease(button) => Some(button.state),
        XEvent::MotionNotify(motion) => Some(motion.state),
        _ => None,
    }
}

/// Buttons 4 and 5 are the wheel.
fn clicked(button: u8, at: [i16; 2], state: KeyButMask, pressed: bool) -> Option<Event> {
    let wheel = |lines: f32| {
        pressed.then(|| Event::MouseWheel {
            unit: MouseWheelUnit::Line,
            delta: vec2(0.0, lines),
            phase: TouchPhase::Move,
            source: MouseWheelSource::Wheel,
            modifiers: modifiers(state),
        })
    };
    let button = match button {
        1 => PointerButton::Primary,
        2 => PointerButton::Middle,
        3 => PointerButton::Secondary,
        4 => return wheel(1.0),
        5 => return wheel(-1.0),
        _ => return None,
    };
    Some(Event::PointerButton {
        pos: place(at),
        button,
        pressed,
        modifiers: modifiers(state),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use x11rb::protocol::xproto::KeyPressEvent;

    fn key(detail: u8, time: u32) -> KeyPressEvent {
        KeyPressEvent {
            response_type: 2,
            detail,
            sequence: 0,
            time,
            root: 0,
            event: 0,
            child: 0,
            root_x: 0,
            root_y: 0,
            event_x: 0,
            event_y: 0,
            state: KeyButMask::default(),
            same_screen: true,
        }
    }

    #[test]
    fn a_key_that_is_held_down_is_pressed_once() {
        let (down, up) = (|t| XEvent::KeyPress(key(65, t)), |t| XEvent::KeyRelease(key(65, t)));
        let held = vec![down(1), up(500), down(500), up(530), down(530), up(700)];
        let words = |events: &[XEvent]| format!("{events:?}");
        let pressed_once = vec![down(1), up(500), up(530), up(700)];
        assert_eq!(words(&without_repeats(held.clone(), &mut None)), words(&pressed_once));
        // Each event with a call of its own: a key held down for 8 s had the screen held and followed 14 times in turn.
        let mut released = None;
        let one_by_one = held.into_iter();
        let kept: Vec<XEvent> = one_by_one
            .flat_map(|event| without_repeats(vec![event], &mut released))
            .collect();
        assert_eq!(words(&kept), words(&pressed_once));
        // Pressed again by a person, and another key at the same moment.
        let again = vec![down(1), up(50), down(90), up(120)];
        assert_eq!(words(&without_repeats(again.clone(), &mut None)), words(&again));
        let other = vec![up(50), XEvent::KeyPress(key(66, 50))];
        assert_eq!(words(&without_repeats(other.clone(), &mut None)), words(&other));
    }

    /// egui forgets what was held down with a key: Shift and [ were [ alone on every real screen, and in no test.
    #[test]
    fn what_is_held_down_reaches_egui_with_whatever_happens() {
        // The signs [ and {, on the key 34.
        let keys = Keyboard {
            first: 34,
            signs_per_key: 2,
            signs: vec![0x5b, 0x7b],
        };
        let context = egui::Context::default();
        let held = |event: XEvent| {
            let events = keys.input(&event);
            let input = egui::RawInput {
                events,
                ..egui::RawInput::default()
            };
            let mut held = egui::Modifiers::default();
            let mut output = context.run_ui(input, |ui| held = ui.input(|input| input.modifiers));
            output.textures_delta.clear();
            held
        };
        let pressed = |state| XEvent::KeyPress(KeyPressEvent { state, ..key(34, 1) });
        assert!(held(pressed(KeyButMask::SHIFT)).shift);
        assert!(!held(pressed(KeyButMask::default())).shift);
        let moved = |state| {
            let KeyPressEvent {
                time,
                root,
                event,
                child,
                ..
            } = key(0, 1);
            XEvent::MotionNotify(x11rb::protocol::xproto::MotionNotifyEvent {
                response_type: 6,
                detail: x11rb::protocol::xproto::Motion::NORMAL,
                sequence: 0,
                time,
                root,
                event,
                child,
                root_x: 0,
                root_y: 0,
                event_x: 5,
                event_y: 6,
                state,
                same_screen: true,
            })
        };
        assert!(held(moved(KeyButMask::CONTROL)).ctrl);
        assert!(!held(moved(KeyButMask::BUTTON1)).ctrl);
    }
}
