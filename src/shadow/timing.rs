//! [`SystemTimes`]: how long the systems of this crate run, for measurements.
//!
//! A system that is added by [`SystemTimes::clock`] is timed by itself, on whichever thread it runs: waiting for other
//! systems is not in its time, and neither are the commands that it leaves behind. Switched off, which is the default,
//! this costs one look at a flag per system and frame.

use std::{
    collections::BTreeMap,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use bevy::{
    ecs::system::{Adapt, IntoAdapterSystem, RunSystemError, SystemIn, SystemInput},
    prelude::*,
};

/// Time by system since it was last taken; one for all worlds of an app.
#[derive(Resource, Clone, Debug, Default)]
pub struct SystemTimes(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    is_on: AtomicBool,
    by_system: Mutex<BTreeMap<&'static str, Duration>>,
}

impl SystemTimes {
    /// That of an app, made where there is none yet.
    pub fn of(app: &mut App) -> Self {
        app.world_mut().get_resource_or_init::<Self>().clone()
    }

    /// Begins or ends recording.
    pub fn switch(&self, on: bool) {
        self.0.is_on.store(on, Ordering::Relaxed);
    }

    /// What was recorded since the last call; runs of one system are added up.
    pub fn take(&self) -> BTreeMap<&'static str, Duration> {
        std::mem::take(&mut *self.0.by_system.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The same system, timed under a name. It keeps its place in schedules: orders that name it still hold.
    pub fn clock<S>(&self, name: &'static str, system: S) -> IntoAdapterSystem<Stopwatch, S> {
        let stopwatch = Stopwatch {
            name,
            times: self.clone(),
        };
        IntoAdapterSystem::new(stopwatch, system)
    }

    fn add(&self, name: &'static str, time: Duration) {
        let mut by_system = self.0.by_system.lock().unwrap_or_else(PoisonError::into_inner);
        *by_system.entry(name).or_default() += time;
    }
}

/// What [`SystemTimes::clock`] puts around a system.
#[derive(Clone, Debug)]
pub struct Stopwatch {
    name: &'static str,
    times: SystemTimes,
}

impl<S: System> Adapt<S> for Stopwatch {
    type In = S::In;
    type Out = S::Out;

    fn adapt(
        &mut self,
        input: <Self::In as SystemInput>::Inner<'_>,
        run_system: impl FnOnce(SystemIn<'_, S>) -> Result<S::Out, RunSystemError>,
    ) -> Result<S::Out, RunSystemError> {
        if !self.times.0.is_on.load(Ordering::Relaxed) {
            return run_system(input);
        }
        let start = Instant::now();
        let result = run_system(input);
        self.times.add(self.name, start.elapsed());
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAP: Duration = Duration::from_millis(3);

    fn sleepy() {
        std::thread::sleep(NAP);
    }

    #[derive(Resource, Default)]
    struct Order(Vec<&'static str>);

    #[test]
    fn runs_are_added_up_while_it_is_on() {
        let mut app = App::new();
        let times = SystemTimes::of(&mut app);
        app.add_systems(Update, times.clock("sleepy", sleepy));
        app.update();
        assert!(times.take().is_empty(), "off by default");
        times.switch(true);
        app.update();
        app.update();
        let taken = times.take();
        assert_eq!(taken.keys().copied().collect::<Vec<_>>(), ["sleepy"]);
        assert!(taken["sleepy"] >= 2 * NAP, "{taken:?}");
        assert!(times.take().is_empty(), "taken");
    }

    #[test]
    fn orders_that_name_a_clocked_system_hold() {
        fn first(mut order: ResMut<Order>) {
            order.0.push("first");
        }
        fn second(mut order: ResMut<Order>) {
            order.0.push("second");
        }
        let mut app = App::new();
        let times = SystemTimes::of(&mut app);
        app.init_resource::<Order>()
            .add_systems(Update, (times.clock("second", second), first.before(second)));
        app.update();
        assert_eq!(app.world().resource::<Order>().0, ["first", "second"]);
    }
}
