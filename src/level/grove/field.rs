//! The cells of a grove as entities: blocks, and near trees with their levels of detail.
//!
//! Who decides what is drawn:
//! - of a closed cell in an open one, the open one's [`LodChain`]: its level 0 are the blocks of its closed children, its
//!   level 1 is its own block. They fade into each other like the levels of any object;
//! - of a tree in an open leaf, the tree's own chain;
//! - of the block of an open leaf, nobody: it is hidden as soon as the leaf's trees are there, in the same frame.
//!
//! A cell changes only while its parent shows its level 0 alone. Few cells change in a frame ([`CHANGES`]); what is late is
//! drawn coarser for some frames, and never missing. When an eye is put elsewhere, everything changes at once.

use std::{
    collections::{BTreeSet, HashMap},
    sync::Arc,
};

use bevy::{
    camera::primitives::Aabb, ecs::system::SystemParam, light::TransmittedShadowReceiver, prelude::*,
    transform::TransformSystems,
};

use super::{
    Grove,
    blocks::{self, FarTrees},
    wind::Swaying,
};
use crate::{
    level::{
        load::LevelEntity,
        model::Placement,
        simple_trees::{LEVEL_ENDS, LEVELS},
        spawn::to_mesh,
    },
    lod::{
        LodSystems,
        chain::{LodChain, LodCoat, LodState},
        eyes::LodEyes,
        settings::{LodKind, LodSettings, LodTransition},
    },
    maths::lod::{
        cells::{Cell, CellBorders, CellChanges, OpenCells},
        crossing::Shown,
        selection::{LodBorders, LodMetric},
    },
};

/// Cells that open, and cells that close, in a frame at most: a fraction of a millisecond each, and enough for 100 m/s.
pub const CHANGES: usize = 2;

/// How trees of a grove are drawn.
#[derive(Clone, Debug)]
pub struct TreeLooks {
    /// Meshes with their boxes, in the order of [`blocks::models`], level by level.
    pub meshes: Vec<Vec<(Handle<Mesh>, Aabb)>>,
    /// Takes colours of vertices.
    pub material: Handle<StandardMaterial>,
}

/// What the cells of all groves did in the last frame.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellCounts {
    /// Entities that stand for whole cells, the hidden blocks of open ones included.
    pub blocks: u32,
    /// Open leaves.
    pub leaves: u32,
    /// Trees in them.
    pub trees: u32,
    /// Cells that opened or closed.
    pub changes: u32,
}

/// The cells of a grove.
#[derive(Component, Debug)]
pub struct CellField {
    grove: Grove,
    far: FarTrees,
    borders: CellBorders,
    /// Of trees.
    tree_borders: Arc<LodBorders>,
    looks: TreeLooks,
    open: OpenCells,
    /// Every cell whose parent is open, and the root.
    nodes: HashMap<Cell, Node>,
}

/// The entities of a cell.
#[derive(Debug, Default)]
struct Node {
    /// `None` of the root, and of cells without trees.
    block: Option<Entity>,
    /// Of an open cell that is neither a leaf nor the root.
    chain: Option<Entity>,
    /// Of an open leaf: chains and their parts.
    trees: Vec<Entity>,
}

/// What cells ask of the rest of the world.
#[derive(SystemParam)]
pub(in crate::level) struct CellWorld<'w, 's> {
    commands: Commands<'w, 's>,
    meshes: ResMut<'w, Assets<Mesh>>,
    eyes: Res<'w, LodEyes>,
    settings: Res<'w, LodSettings>,
    states: Query<'w, 's, &'static LodState>,
}

impl CellWorld<'_, '_> {
    /// What the chain of a cell shows; the root has none and always shows its children.
    fn shown(&self, node: Option<&Node>) -> Option<Shown> {
        match node?.chain {
            None => Some(Shown::Level(0)),
            Some(chain) => self.states.get(chain).ok()?.shown(),
        }
    }

    /// Cells fade as all things do, but not by dither: Bevy's ranges are those of single entities.
    fn transition(&self) -> LodTransition {
        match self.settings.transition.kind {
            LodKind::Dither => LodTransition {
                kind: LodKind::Hard,
                ..self.settings.transition
            },
            _ => self.settings.transition,
        }
    }
}

/// Runs [`CellField`]s in apps that have levels of detail.
pub fn plugin(app: &mut App) {
    app.init_resource::<CellCounts>()
        .add_systems(
            PostUpdate,
            update_cells
                .after(LodSystems::Look)
                .before(LodSystems::Select)
                .before(TransformSystems::Propagate)
                .run_if(resource_exists::<LodEyes>),
        )
        .add_plugins(super::wind::plugin);
}

/// Opens and closes cells.
fn update_cells(mut fields: Query<&mut CellField>, mut world: CellWorld, mut counts: ResMut<CellCounts>) {
    let mut found = CellCounts::default();
    if !world.eyes.is_empty() {
        for mut field in &mut fields {
            found.changes += field.update(&mut world) as u32;
        }
    }
    for (_, block, trees) in fields.iter().flat_map(CellField::cells) {
        found.blocks += u32::from(block.is_some());
        found.leaves += u32::from(trees > 0);
        found.trees += trees as u32;
    }
    counts.set_if_neq(found);
}

impl CellField {
    /// A field that has nothing yet: the first eye brings everything.
    pub fn new(grove: Grove, looks: TreeLooks) -> Self {
        Self {
            grove,
            far: FarTrees::default(),
            borders: grove.borders(),
            tree_borders: Arc::new(LodBorders::new(LEVEL_ENDS.map(f64::from))),
            looks,
            open: OpenCells::new(grove.grid()),
            nodes: HashMap::new(),
        }
    }

    /// Every cell whose parent is open: its block, and how many trees of it stand alone.
    pub fn cells(&self) -> impl Iterator<Item = (Cell, Option<Entity>, usize)> {
        let nodes = self.nodes.iter();
        nodes.map(|(cell, node)| (*cell, node.block, node.trees.len() / (LEVELS + 1)))
    }

    /// The trees.
    pub fn grove(&self) -> &Grove {
        &self.grove
    }

    /// One frame; how many cells changed.
    fn update(&mut self, world: &mut CellWorld) -> usize {
        let mut stale = BTreeSet::new();
        let mut count = 0;
        if self.nodes.is_empty() {
            let root = self.open.grid().root();
            self.nodes.insert(root, Node::default());
            self.fill(world, root);
            count += 1;
        }
        if world.eyes.have_jumped() {
            loop {
                let changes = self.wanted(world);
                if changes.is_empty() {
                    break;
                }
                count += self.change(world, &changes, &mut stale);
            }
        } else {
            let mut changes = self.wanted(world);
            changes.open.retain(|cell| self.may_open(world, *cell));
            changes.open.truncate(CHANGES);
            changes.close.retain(|cell| self.may_close(world, *cell));
            changes.close.truncate(CHANGES);
            count += self.change(world, &changes, &mut stale);
        }
        if world.settings.is_changed() {
            stale.extend(self.open.iter());
        }
        for cell in stale {
            self.chain_up(world, cell);
        }
        count
    }

    /// What distances ask for.
    fn wanted(&self, world: &CellWorld) -> CellChanges {
        let late = match world.settings.transition.kind {
            LodKind::Late => f64::from(world.settings.late_factor).max(1.0),
            _ => 1.0,
        };
        self.open.changes(&self.borders, |cell| {
            world.eyes.distance(self.middle(cell), LodMetric::Distance) / late
        })
    }

    /// The middle of a cell on the ground.
    fn middle(&self, cell: Cell) -> Vec3 {
        let center = self.open.grid().center(cell).as_vec2();
        Vec3::new(center.x, self.grove.land().height(center), center.y)
    }

    fn may_open(&self, world: &CellWorld, cell: Cell) -> bool {
        world.shown(self.nodes.get(&cell.parent())) == Some(Shown::Level(0))
    }

    fn may_close(&self, world: &CellWorld, cell: Cell) -> bool {
        let own_is_alone = cell.level == 0 || world.shown(self.nodes.get(&cell)) == Some(Shown::Level(1));
        let parent = world.shown(self.nodes.get(&cell.parent()));
        own_is_alone && matches!(parent, Some(Shown::Level(_)))
    }

    /// Closes and opens cells; `stale` gets those whose chains have other parts now.
    fn change(&mut self, world: &mut CellWorld, changes: &CellChanges, stale: &mut BTreeSet<Cell>) -> usize {
        for cell in &changes.close {
            self.close(world, *cell);
            stale.insert(cell.parent());
        }
        for cell in &changes.open {
            self.open.open(*cell);
            self.fill(world, *cell);
            stale.extend([*cell, cell.parent()]);
        }
        changes.close.len() + changes.open.len()
    }

    /// Gives an open cell what is in it.
    fn fill(&mut self, world: &mut CellWorld, cell: Cell) {
        if cell.level == 0 {
            let trees = self.spawn_trees(world, cell);
            let node = self.nodes.entry(cell).or_default();
            node.trees = trees;
            if let Some(block) = node.block {
                world.commands.entity(block).insert(Visibility::Hidden);
            }
            return;
        }
        let is_root = cell == self.open.grid().root();
        if !is_root {
            let place = Transform::from_translation(self.middle(cell));
            let chain = world.commands.spawn((place, LevelEntity)).id();
            self.nodes.entry(cell).or_default().chain = Some(chain);
        }
        // The chain will show one of its levels in this frame.
        let visibility = if is_root {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        };
        let children: Vec<Cell> = self.open.grid().children(cell).collect();
        for child in children {
            let block = self.spawn_block(world, child, visibility);
            self.nodes.insert(child, Node { block, ..default() });
        }
    }

    /// Takes everything out of a cell whose children are closed, and draws its block instead.
    fn close(&mut self, world: &mut CellWorld, cell: Cell) {
        self.open.close(cell);
        let shown_of_parent = world.shown(self.nodes.get(&cell.parent()));
        let children: Vec<Cell> = self.open.grid().children(cell).collect();
        for block in children.iter().filter_map(|child| self.nodes.remove(child)?.block) {
            world.commands.entity(block).despawn();
        }
        let Some(node) = self.nodes.get_mut(&cell) else { return };
        for entity in node.trees.drain(..).chain(node.chain.take()) {
            world.commands.entity(entity).despawn();
        }
        if let Some(block) = node.block {
            let visibility = match shown_of_parent {
                Some(Shown::Level(1)) => Visibility::Hidden,
                _ => Visibility::Inherited,
            };
            world.commands.entity(block).insert(visibility).try_remove::<LodCoat>();
        }
    }

    /// Tells the chain of an open cell which blocks are its levels.
    fn chain_up(&self, world: &mut CellWorld, cell: Cell) {
        let Some(chain) = self.nodes.get(&cell).and_then(|node| node.chain) else {
            return;
        };
        let blocks = |cells: &mut dyn Iterator<Item = Cell>| -> Vec<Entity> {
            cells.filter_map(|cell| self.nodes.get(&cell)?.block).collect()
        };
        let children = blocks(&mut self.open.closed_children(cell));
        let levels = vec![children, blocks(&mut std::iter::once(cell))];
        let borders = Arc::new(LodBorders::new([self.borders.border(cell.level)]));
        let transition = world.transition();
        world.commands.entity(chain).insert((
            LodChain {
                levels,
                borders,
                metric: LodMetric::Distance,
            },
            transition,
        ));
    }

    /// `None` where no trees are left.
    fn spawn_block(&self, world: &mut CellWorld, cell: Cell, visibility: Visibility) -> Option<Entity> {
        let data = blocks::block(&self.grove, &self.far, cell);
        let (min, max) = data.bounds()?;
        let block = world.commands.spawn((
            Mesh3d(world.meshes.add(to_mesh(data))),
            MeshMaterial3d(self.looks.material.clone()),
            Aabb::from_min_max(min, max),
            Transform::from_translation(blocks::origin(&self.grove, cell)),
            visibility,
            LevelEntity,
            TransmittedShadowReceiver,
        ));
        Some(block.id())
    }

    /// The trees of a leaf with their chains.
    fn spawn_trees(&self, world: &mut CellWorld, cell: Cell) -> Vec<Entity> {
        let mut entities = Vec::new();
        for tree in self.grove.trees_in(cell) {
            let Some(meshes) = blocks::index(tree.model).and_then(|index| self.looks.meshes.get(index)) else {
                continue;
            };
            let place = transform(&tree);
            let swaying = Swaying::new(&tree, self.grove.wind());
            let parts: Vec<Entity> = meshes
                .iter()
                .enumerate()
                .map(|(level, (mesh, aabb))| {
                    let mut part = world.commands.spawn((
                        Mesh3d(mesh.clone()),
                        MeshMaterial3d(self.looks.material.clone()),
                        *aabb,
                        place,
                        Visibility::Hidden,
                        LevelEntity,
                        TransmittedShadowReceiver,
                    ));
                    // The last level stays as the block has it.
                    if self.grove.wind() > 0.0 && level + 1 < meshes.len() {
                        part.insert(swaying);
                    }
                    part.id()
                })
                .collect();
            entities.extend(&parts);
            let chain = LodChain {
                levels: parts.into_iter().map(|part| vec![part]).collect(),
                borders: self.tree_borders.clone(),
                metric: LodMetric::Distance,
            };
            entities.push(world.commands.spawn((place, chain, LevelEntity)).id());
        }
        entities
    }
}

fn transform(tree: &Placement) -> Transform {
    Transform {
        translation: tree.position,
        rotation: tree.rotation,
        scale: tree.scale,
    }
}
