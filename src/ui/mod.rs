//! Head-up display, help and menus.
