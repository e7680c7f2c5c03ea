//! Shader twins: they compile, and have the functions and the constants of the Rust ones.

use naga::{
    Expression, Literal,
    front::wgsl::parse_str,
    valid::{Capabilities, ValidationFlags, Validator},
};
use umbrage::maths::sampling_rate::RATE_KNOTS;

const TYPES: &str = include_str!("../../shaders/types.wgsl");
const SPACES: &str = include_str!("../../shaders/spaces.wgsl");
const BIAS: &str = include_str!("../../shaders/bias.wgsl");
const SURFACE: &str = include_str!("../../shaders/surface.wgsl");
const DEPTH_OFFSET: &str = include_str!("../../shaders/depth_offset.wgsl");
const FADING: &str = include_str!("../../shaders/fading.wgsl");
const FILTER: &str = include_str!("../../shaders/filter.wgsl");
const SELECTION: &str = include_str!("../../shaders/selection.wgsl");
const VISIBILITY: &str = include_str!("../../shaders/visibility.wgsl");
const EYE_BLUR: &str = include_str!("../../shaders/blur/eye_blur.wgsl");

/// What the imported modules of the engine declare, as far as it is used.
const ENGINE: &str = "
struct View {
    clip_from_world: mat4x4<f32>,
    world_from_clip: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    world_from_view: mat4x4<f32>,
    clip_from_view: mat4x4<f32>,
    world_position: vec3<f32>,
    viewport: vec4<f32>,
}
struct FullscreenVertexOutput {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
}
";

/// Modules pasted together instead of imported: names are unique, because every import is of single items.
fn compose(modules: &[&str]) -> naga::Module {
    let source: String = modules
        .iter()
        .flat_map(|module| without_directives(module))
        .map(|line| format!("{line}\n"))
        .collect();
    let module = parse_str(&source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
    validator
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
    module
}

/// Lines of a module besides those for the preprocessor; imports may have many lines. Conditional parts stay.
fn without_directives(module: &str) -> Vec<&str> {
    let mut is_in_import = false;
    let is_kept = |line: &&str| {
        let is_directive = line.starts_with('#') || is_in_import;
        is_in_import = (line.starts_with("#import") && line.ends_with('{')) || (is_in_import && !line.starts_with('}'));
        !is_directive
    };
    module.lines().filter(is_kept).collect()
}

#[test]
fn passes_compile_with_what_they_import() {
    let library = [
        ENGINE,
        TYPES,
        SPACES,
        BIAS,
        SURFACE,
        DEPTH_OFFSET,
        FADING,
        FILTER,
        SELECTION,
    ];
    for pass in [
        [VISIBILITY, include_str!("../../shaders/apply/apply_views.wgsl")],
        [VISIBILITY, include_str!("../../shaders/virtual_map/apply_tile.wgsl")],
        ["", include_str!("../../shaders/virtual_map/show_tiles.wgsl")],
    ] {
        let module = compose(&[&library[..], &pass].concat());
        assert_eq!(module.entry_points.len(), 1, "one pass");
    }
}

fn functions(module: &naga::Module) -> Vec<String> {
    module
        .functions
        .iter()
        .filter_map(|(_, function)| function.name.clone())
        .collect()
}

#[test]
fn filters_compile_with_the_functions_of_their_twins() {
    let module = compose(&[ENGINE, SPACES, BIAS, DEPTH_OFFSET, FADING, FILTER]);
    let names = functions(&module);
    for (file, source) in [
        ("lookup", include_str!("../../src/maths/filter/lookup.rs")),
        ("fading", include_str!("../../src/maths/filter/fading.rs")),
        ("disc", include_str!("../../src/maths/filter/disc.rs")),
        ("kernel", include_str!("../../src/maths/filter/kernel.rs")),
        ("penumbra", include_str!("../../src/maths/filter/penumbra.rs")),
    ] {
        for name in twin_functions(source) {
            assert!(names.contains(&name), "{file}: {name} has no twin among {names:?}");
        }
    }
    for name in [
        "constant_offset",
        "slope_scaled_offset",
        "texel_side",
        "world_slope_offset",
        "texel_span",
        "float_step",
    ] {
        assert!(names.iter().any(|other| other == name), "{name} has no twin");
    }
}

/// Names of the free functions of a file.
fn twin_functions(source: &str) -> Vec<String> {
    let names = source.lines().filter_map(|line| {
        let rest = line
            .strip_prefix("pub fn ")
            .or_else(|| line.strip_prefix("pub(super) fn "))?;
        rest.split(['(', '<']).next().map(str::to_owned)
    });
    names.collect()
}

#[test]
fn the_blur_compiles_with_the_functions_of_its_twin() {
    let module = compose(&[ENGINE, TYPES, SPACES, SURFACE, EYE_BLUR]);
    let names = functions(&module);
    for name in twin_functions(include_str!("../../src/maths/filter/eye_blur.rs")) {
        assert!(names.contains(&name), "{name} has no twin among {names:?}");
    }
    assert_eq!(module.entry_points.len(), 1, "one pass");
}

#[test]
fn sampling_rates_compile_with_the_knots_of_their_twin() {
    const RATE: &str = include_str!("../../shaders/heat_map/sampling_rate.wgsl");
    let library = [
        ENGINE,
        TYPES,
        SPACES,
        BIAS,
        SURFACE,
        DEPTH_OFFSET,
        FADING,
        FILTER,
        SELECTION,
    ];
    for definitions in [&[][..], &["UMBRAGE_RATE_ACROSS"], &["UMBRAGE_RATE_ALONG"]] {
        let source = with_definitions(RATE, definitions);
        assert_eq!(
            source.contains("abs(determinant("),
            definitions.is_empty(),
            "area without a definition"
        );
        assert!(
            source.matches("    return length(").count() <= 1,
            "one measure at a time"
        );
        let module = compose(&[&library[..], &[&source]].concat());
        assert_eq!(module.entry_points.len(), 1, "one pass");
        let knots = numbers_of(&module, "RATE_KNOTS");
        let wanted = RATE_KNOTS.map(|(rate, color)| [color.x, color.y, color.z, rate]);
        assert_eq!(knots, wanted.concat(), "{definitions:?}");
    }
}

/// All numbers of a constant, in order.
fn numbers_of(module: &naga::Module, name: &str) -> Vec<f32> {
    let found = module
        .constants
        .iter()
        .find(|(_, constant)| constant.name.as_deref() == Some(name));
    let (_, constant) = found.unwrap_or_else(|| panic!("no constant {name}"));
    let (mut left, mut numbers) = (vec![constant.init], Vec::new());
    while let Some(expression) = left.pop() {
        match &module.global_expressions[expression] {
            Expression::Compose { components, .. } => left.extend(components.iter().rev()),
            Expression::Literal(Literal::F32(number)) => numbers.push(*number),
            other => panic!("{name} is not made of numbers: {other:?}"),
        }
    }
    numbers
}

/// The value of a constant in a shader or in Rust.
fn constant(source: &str, name: &str) -> f64 {
    let declaration = format!("const {name}: ");
    let line = source
        .lines()
        .find(|line| line.trim_start_matches("pub ").starts_with(&declaration));
    let value = line
        .and_then(|line| line.split('=').nth(1))
        .unwrap_or_else(|| panic!("no constant {name}"));
    let digits: String = value
        .chars()
        .filter(|character| character.is_ascii_digit() || ['.', 'e', '-'].contains(character))
        .collect();
    digits.parse().unwrap_or_else(|_| panic!("{name} is {value}"))
}

#[test]
fn constants_agree() {
    let disc = include_str!("../../src/maths/filter/disc.rs");
    let blur = include_str!("../../src/maths/filter/eye_blur.rs");
    let offset = include_str!("../../src/maths/depth_offset.rs");
    for (rust, shader, names) in [
        (disc, FILTER, &["GOLDEN_ANGLE"][..]),
        (
            blur,
            EYE_BLUR,
            &["MAX_ITERATIONS", "SAME_SURFACE_COSINE", "LARGEST_STEP", "LEAST_SHARE"][..],
        ),
        (offset, DEPTH_OFFSET, &["SMALLEST_DEPTH"][..]),
    ] {
        for name in names {
            let strip = |source: &str| constant(&source.replace("u32 = 16u", "u32 = 16"), name);
            assert_eq!(strip(rust), strip(shader), "{name}");
        }
    }
}

/// A source without the lines that its definitions leave out.
fn with_definitions(source: &str, definitions: &[&str]) -> String {
    let mut is_taken = vec![true];
    let mut lines = String::new();
    for line in source.lines() {
        if let Some(name) = line.strip_prefix("#ifdef ") {
            is_taken.push(definitions.contains(&name));
        } else if line == "#else" {
            let last = is_taken.pop().expect("an #else belongs to an #ifdef");
            is_taken.push(!last);
        } else if line == "#endif" {
            is_taken.pop();
        } else if is_taken.iter().all(|taken| *taken) {
            lines += line;
            lines += "\n";
        }
    }
    assert_eq!(is_taken, [true], "every #ifdef ends");
    lines
}

#[test]
fn needs_compile_with_the_functions_of_their_twins() {
    const NEEDS: &str = include_str!("../../shaders/virtual_map/needs.wgsl");
    const COLLECT: &str = include_str!("../../shaders/virtual_map/collect_needs.wgsl");
    const MAP: &str = include_str!("../../shaders/virtual_map/map_needs.wgsl");
    const SHOW: &str = include_str!("../../shaders/virtual_map/show_needs.wgsl");
    let mapping = include_str!("../../src/maths/virtual_map/mapping.rs");
    for (source, definitions) in [
        (COLLECT, &[][..]),
        (COLLECT, &["HISTOGRAM"]),
        (MAP, &[]),
        (MAP, &["BYTES"]),
        (SHOW, &[]),
    ] {
        let source = with_definitions(source, definitions);
        let module = compose(&[ENGINE, TYPES, SPACES, SURFACE, NEEDS, &source]);
        let names = functions(&module);
        for name in [
            "picked_slope",
            "need_level",
            "listed_extent",
            "depth_of_linear",
            "dilated_need",
        ] {
            assert!(names.iter().any(|known| known == name), "no {name} in {names:?}");
        }
    }
    for name in ["picked_slope", "need_level", "listed_extent"] {
        assert!(mapping.contains(&format!("fn {name}(")), "no twin of {name}");
    }
}
