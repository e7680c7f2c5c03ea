//! Keys and mouse to [`Intent`]: what the player wants, without saying which device said it.
//!
//! [`ROWS`] is the only list of keys: the mapping reads it, the F1 table and the tests are made from it.

use bevy::{
    input::{InputSystems, mouse::AccumulatedMouseMotion},
    prelude::*,
};

/// Something a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Walk or fly along the view.
    Forward,
    /// Against it.
    Back,
    /// To the left.
    Left,
    /// To the right.
    Right,
    /// Upwards, when flying.
    Up,
    /// Downwards, when flying.
    Down,
    /// While held: faster.
    Faster,
    /// Turn the view; the mouse does it.
    Look,
    /// Between walking and flying.
    ToggleFly,
    /// Show or hide the table of keys.
    ToggleHelp,
    /// Stop the game or go on with it.
    TogglePause,
    /// Leave, from the pause menu.
    Quit,
    /// The next technique of the list.
    NextTechnique,
    /// The one before.
    PreviousTechnique,
    /// The next value of one of the technique's settings, by the number of its key, from 1.
    NextSetting(u8),
    /// The value before.
    PreviousSetting(u8),
    /// Turn the sun counter-clockwise, seen from above.
    SunLeft,
    /// Turn the sun clockwise.
    SunRight,
    /// Raise the sun.
    SunUp,
    /// Lower the sun.
    SunDown,
    /// While held: the mouse moves the sun instead of the view.
    SunDrag,
    /// Let the day run or stop it.
    ToggleDay,
    /// Switch the sway of the view in walking on or off.
    ToggleBob,
    /// The next overlay.
    NextOverlay,
    /// The next way in which levels of detail take each other's place.
    NextLod,
    /// The next way for the right half of the picture.
    NextLodOnTheRight,
    /// Show or hide the view from outside.
    ToggleOutside,
    /// Freeze the frame and compare it with truth, or go on.
    Judge,
    /// Save a picture.
    Photo,
    /// The next level of the list.
    NextScene,
}

/// What sets an action off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trigger {
    /// A key, with or without Shift.
    Key(KeyCode),
    /// A key without Shift.
    Plain(KeyCode),
    /// A key together with Shift.
    Shift(KeyCode),
    /// Moving the mouse.
    Mouse,
}

/// When a row of the table works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// While playing.
    Playing,
    /// In the pause menu.
    Paused,
    /// In both.
    Both,
}

/// One line of the table of keys.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// What the keys do, for the reader.
    pub does: &'static str,
    /// When they do it.
    pub when: When,
    /// Which trigger sets off which action.
    pub triggers: &'static [(Trigger, Action)],
}

const fn playing(does: &'static str, triggers: &'static [(Trigger, Action)]) -> Row {
    Row {
        does,
        when: When::Playing,
        triggers,
    }
}

/// Every key of the demo. Whatever is not here does nothing.
pub const ROWS: &[Row] = {
    use Action::*;
    use Trigger::*;
    &[
        playing(
            "walk",
            &[
                (Key(KeyCode::KeyW), Forward),
                (Key(KeyCode::KeyA), Left),
                (Key(KeyCode::KeyS), Back),
                (Key(KeyCode::KeyD), Right),
            ],
        ),
        playing(
            "faster, while held",
            &[(Key(KeyCode::ShiftLeft), Faster), (Key(KeyCode::ShiftRight), Faster)],
        ),
        playing("look around", &[(Mouse, Look)]),
        playing("fly or walk", &[(Key(KeyCode::KeyF), ToggleFly)]),
        playing("sway of the view in walking", &[(Key(KeyCode::KeyB), ToggleBob)]),
        playing(
            "up, when flying",
            &[(Key(KeyCode::KeyE), Up), (Key(KeyCode::Space), Up)],
        ),
        playing(
            "down, when flying",
            &[(Key(KeyCode::KeyQ), Down), (Key(KeyCode::ControlLeft), Down)],
        ),
        playing("next technique", &[(Plain(KeyCode::KeyT), NextTechnique)]),
        playing("previous technique", &[(Shift(KeyCode::KeyT), PreviousTechnique)]),
        playing(
            "next value of a setting",
            &[
                (Plain(KeyCode::Digit1), NextSetting(1)),
                (Plain(KeyCode::Digit2), NextSetting(2)),
                (Plain(KeyCode::Digit3), NextSetting(3)),
                (Plain(KeyCode::Digit4), NextSetting(4)),
                (Plain(KeyCode::Digit5), NextSetting(5)),
                (Plain(KeyCode::Digit6), NextSetting(6)),
                (Plain(KeyCode::Digit7), NextSetting(7)),
                (Plain(KeyCode::Digit8), NextSetting(8)),
                (Plain(KeyCode::Digit9), NextSetting(9)),
            ],
        ),
        playing(
            "previous value of a setting",
            &[
                (Shift(KeyCode::Digit1), PreviousSetting(1)),
                (Shift(KeyCode::Digit2), PreviousSetting(2)),
                (Shift(KeyCode::Digit3), PreviousSetting(3)),
                (Shift(KeyCode::Digit4), PreviousSetting(4)),
                (Shift(KeyCode::Digit5), PreviousSetting(5)),
                (Shift(KeyCode::Digit6), PreviousSetting(6)),
                (Shift(KeyCode::Digit7), PreviousSetting(7)),
                (Shift(KeyCode::Digit8), PreviousSetting(8)),
                (Shift(KeyCode::Digit9), PreviousSetting(9)),
            ],
        ),
        playing(
            "next value of one of the last settings",
            &[
                (Plain(KeyCode::Digit0), NextSetting(10)),
                (Plain(KeyCode::Minus), NextSetting(11)),
            ],
        ),
        playing(
            "previous value of one of the last settings",
            &[
                (Shift(KeyCode::Digit0), PreviousSetting(10)),
                (Shift(KeyCode::Minus), PreviousSetting(11)),
            ],
        ),
        playing(
            "move the sun",
            &[
                (Key(KeyCode::ArrowLeft), SunLeft),
                (Key(KeyCode::ArrowRight), SunRight),
                (Key(KeyCode::ArrowUp), SunUp),
                (Key(KeyCode::ArrowDown), SunDown),
            ],
        ),
        playing("move the sun by mouse, while held", &[(Key(KeyCode::KeyL), SunDrag)]),
        playing("let the day run, stop it", &[(Key(KeyCode::KeyK), ToggleDay)]),
        playing("overlays", &[(Key(KeyCode::KeyO), NextOverlay)]),
        playing("levels of detail", &[(Plain(KeyCode::KeyV), NextLod)]),
        playing(
            "levels of detail of the right half",
            &[(Shift(KeyCode::KeyV), NextLodOnTheRight)],
        ),
        playing("outside view", &[(Key(KeyCode::F5), ToggleOutside)]),
        playing("judge the frozen frame against truth", &[(Key(KeyCode::KeyJ), Judge)]),
        playing("photo into out/", &[(Key(KeyCode::KeyP), Photo)]),
        playing("next level", &[(Key(KeyCode::KeyN), NextScene)]),
        Row {
            does: "this help",
            when: When::Both,
            triggers: &[(Key(KeyCode::F1), ToggleHelp)],
        },
        Row {
            does: "pause, go on",
            when: When::Both,
            triggers: &[(Key(KeyCode::Escape), TogglePause)],
        },
        Row {
            does: "quit, from the pause menu",
            when: When::Paused,
            triggers: &[(Key(KeyCode::KeyQ), Quit)],
        },
    ]
};

impl Row {
    /// The triggers as a reader writes them: `W A S D`, `Shift+T`; a run of digits is shortened to `1..9`.
    pub fn label(&self) -> String {
        let mut names = Vec::new();
        for (trigger, _) in self.triggers {
            let name = trigger.label();
            if !names.contains(&name) {
                names.push(name);
            }
        }
        match names.as_slice() {
            [first, .., last] if names.len() > 4 => {
                format!("{first}..{}", last.strip_prefix("Shift+").unwrap_or(last))
            }
            _ => names.join(" "),
        }
    }
}

impl Trigger {
    /// The name on the key cap.
    pub fn label(&self) -> String {
        match self {
            Self::Key(key) | Self::Plain(key) => key_name(*key),
            Self::Shift(key) => format!("Shift+{}", key_name(*key)),
            Self::Mouse => "Mouse".into(),
        }
    }

    fn key(&self) -> Option<KeyCode> {
        match self {
            Self::Key(key) | Self::Plain(key) | Self::Shift(key) => Some(*key),
            Self::Mouse => None,
        }
    }

    fn allows(&self, shift: bool) -> bool {
        match self {
            Self::Key(_) => true,
            Self::Plain(_) => !shift,
            Self::Shift(_) => shift,
            Self::Mouse => false,
        }
    }
}

fn key_name(key: KeyCode) -> String {
    let name = format!("{key:?}");
    match key {
        KeyCode::Escape => "Esc".into(),
        KeyCode::Minus => "-".into(),
        KeyCode::ShiftLeft | KeyCode::ShiftRight => "Shift".into(),
        KeyCode::ControlLeft | KeyCode::ControlRight => "Ctrl".into(),
        _ => ["Key", "Digit", "Arrow"]
            .iter()
            .find_map(|prefix| name.strip_prefix(prefix))
            .unwrap_or(&name)
            .into(),
    }
}

/// What the player wants this frame.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Intent {
    /// Right, up, forward; each −1, 0 or 1.
    pub movement: Vec3,
    /// Move faster.
    pub faster: bool,
    /// Yaw to the left and pitch upwards, in radians.
    pub look: Vec2,
    /// Azimuth and elevation of the sun: each −1, 0 or 1, to be multiplied by a speed.
    pub sun: Vec2,
    /// Azimuth and elevation of the sun, in radians.
    pub sun_drag: Vec2,
    /// Actions whose key went down.
    pub started: Vec<Action>,
}

/// Radians of view per pixel of mouse motion.
const RADIANS_PER_PIXEL: f32 = 0.0022;
/// A frame's mouse motion beyond this many pixels is a device error.
const MAX_MOUSE_PIXELS: f32 = 4000.0;

impl Intent {
    /// Reads keys and the mouse motion of one frame, in pixels to the right and down.
    pub fn read(keys: &ButtonInput<KeyCode>, mouse: Vec2) -> Self {
        let shift = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
        let bindings = || ROWS.iter().flat_map(|row| row.triggers);
        let held = |action: Action| {
            bindings().any(|(trigger, bound)| {
                *bound == action && trigger.allows(shift) && trigger.key().is_some_and(|key| keys.pressed(key))
            })
        };
        let axis = |minus: Action, plus: Action| f32::from(i8::from(held(plus)) - i8::from(held(minus)));

        let started = bindings()
            .filter(|(trigger, _)| trigger.allows(shift) && trigger.key().is_some_and(|key| keys.just_pressed(key)))
            .map(|(_, action)| *action)
            .collect();

        let mouse = if mouse.is_finite() {
            mouse.clamp_length_max(MAX_MOUSE_PIXELS)
        } else {
            Vec2::ZERO
        };
        let turn = -mouse * RADIANS_PER_PIXEL;
        let (look, sun_drag) = if held(Action::SunDrag) {
            (Vec2::ZERO, Vec2::new(-turn.x, turn.y))
        } else {
            (turn, Vec2::ZERO)
        };
        Self {
            movement: Vec3::new(
                axis(Action::Left, Action::Right),
                axis(Action::Down, Action::Up),
                axis(Action::Back, Action::Forward),
            ),
            faster: held(Action::Faster),
            look,
            sun: Vec2::new(
                axis(Action::SunLeft, Action::SunRight),
                axis(Action::SunDown, Action::SunUp),
            ),
            sun_drag,
            started,
        }
    }

    /// Whether the key of `action` went down this frame.
    pub fn started(&self, action: Action) -> bool {
        self.started.contains(&action)
    }

    /// The setting (1..=9) whose key went down this frame, and whether to step backwards.
    pub fn setting(&self) -> Option<(u8, bool)> {
        self.started.iter().find_map(|action| match action {
            Action::NextSetting(number) => Some((*number, false)),
            Action::PreviousSetting(number) => Some((*number, true)),
            _ => None,
        })
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Intent>()
        .add_systems(PreUpdate, read_input.after(InputSystems));
}

fn read_input(keys: Res<ButtonInput<KeyCode>>, mouse: Res<AccumulatedMouseMotion>, mut intent: ResMut<Intent>) {
    *intent = Intent::read(&keys, mouse.delta);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressed(keys: &[KeyCode]) -> ButtonInput<KeyCode> {
        let mut input = ButtonInput::default();
        for key in keys {
            input.press(*key);
        }
        input
    }

    #[test]
    fn keys_move_along_the_three_axes_and_cancel_out() {
        let intent = Intent::read(&pressed(&[KeyCode::KeyW, KeyCode::KeyD, KeyCode::Space]), Vec2::ZERO);
        assert_eq!(intent.movement, Vec3::new(1.0, 1.0, 1.0), "right, up, forward");
        let intent = Intent::read(&pressed(&[KeyCode::KeyW, KeyCode::KeyS, KeyCode::KeyA]), Vec2::ZERO);
        assert_eq!(intent.movement, Vec3::new(-1.0, 0.0, 0.0), "opposite keys cancel out");
        assert!(!intent.faster, "no Shift");
        assert!(
            Intent::read(&pressed(&[KeyCode::ShiftRight]), Vec2::ZERO).faster,
            "either Shift"
        );
    }

    #[test]
    fn shift_chooses_between_next_and_previous() {
        let plain = Intent::read(&pressed(&[KeyCode::KeyT, KeyCode::Digit3]), Vec2::ZERO);
        assert!(
            plain.started(Action::NextTechnique) && !plain.started(Action::PreviousTechnique),
            "T"
        );
        assert_eq!(plain.setting(), Some((3, false)), "3");
        let shifted = Intent::read(
            &pressed(&[KeyCode::ShiftLeft, KeyCode::KeyT, KeyCode::Digit3]),
            Vec2::ZERO,
        );
        assert!(
            shifted.started(Action::PreviousTechnique) && !shifted.started(Action::NextTechnique),
            "Shift+T"
        );
        assert_eq!(shifted.setting(), Some((3, true)), "Shift+3");
    }

    #[test]
    fn an_action_starts_once_per_press() {
        let mut keys = pressed(&[KeyCode::KeyF]);
        assert!(
            Intent::read(&keys, Vec2::ZERO).started(Action::ToggleFly),
            "first frame"
        );
        keys.clear();
        assert!(
            !Intent::read(&keys, Vec2::ZERO).started(Action::ToggleFly),
            "still held"
        );
    }

    #[test]
    fn the_mouse_turns_the_view_or_with_l_the_sun() {
        let look = Intent::read(&pressed(&[]), Vec2::new(10.0, 0.0));
        assert!(
            look.look.x < 0.0 && look.sun_drag == Vec2::ZERO,
            "to the right is negative yaw"
        );
        let drag = Intent::read(&pressed(&[KeyCode::KeyL]), Vec2::new(10.0, -5.0));
        assert_eq!(drag.look, Vec2::ZERO, "the view stands still");
        assert!(drag.sun_drag.x > 0.0 && drag.sun_drag.y > 0.0, "right and up");
        assert_eq!(Intent::read(&pressed(&[]), Vec2::NAN).look, Vec2::ZERO, "not a number");
    }

    #[test]
    fn no_key_does_two_things_at_once() {
        let mut seen: Vec<(Trigger, When)> = Vec::new();
        for row in ROWS {
            for (trigger, _) in row.triggers {
                for (other, when) in &seen {
                    let together = row.when == *when || row.when == When::Both || *when == When::Both;
                    let same_key = trigger.key().is_some() && trigger.key() == other.key();
                    let same_shift = [false, true]
                        .iter()
                        .any(|shift| trigger.allows(*shift) && other.allows(*shift));
                    assert!(!(together && same_key && same_shift), "{trigger:?} is bound twice");
                }
                seen.push((*trigger, row.when));
            }
        }
    }

    #[test]
    fn labels_read_like_key_caps() {
        let label = |action: Action| {
            let row = ROWS
                .iter()
                .find(|row| row.triggers.iter().any(|(_, bound)| *bound == action));
            row.map(Row::label).unwrap_or_default()
        };
        assert_eq!(label(Action::Forward), "W A S D");
        assert_eq!(label(Action::Faster), "Shift");
        assert_eq!(label(Action::PreviousSetting(1)), "Shift+1..9");
        assert_eq!(label(Action::Up), "E Space");
        assert_eq!(label(Action::SunUp), "Left Right Up Down");
        assert_eq!(label(Action::TogglePause), "Esc");
        assert_eq!(label(Action::Look), "Mouse");
        for row in ROWS {
            assert!(
                row.does.is_ascii() && row.label().is_ascii(),
                "the font has ASCII only: {row:?}"
            );
        }
    }
}
