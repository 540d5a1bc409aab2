//! Every tolerance and physical constant of the simulator, with its unit and what it does.

/// Length below which the geometry of contacts tells nothing apart, m: the unit of the tolerances that are written as
/// shares of it.
pub const LINEAR_SLOP: f32 = 1e-4;

/// Depth up to which two parts only touch and the energy counts no penetration, m (the paper is silent; see
/// `EnergyWeights`).
pub const TOUCHING_DEPTH: f32 = 1e-3;

/// Angle that does not count when a candidate is sure to lose, rad: more than rounding adds to one.
pub const PRUNING_ANGLE: f32 = 1e-5;

/// Share of what it is sure to cost that does not count then: more than rounding adds to distances and sums.
pub const PRUNING_SHARE: f32 = 1e-3;

/// Most vertices of a hull (the paper's limit).
pub const MAX_HULL_VERTICES: usize = 64;

/// Most corners of a face polygon that clipping works on; larger polygons are cut into several, supports are not.
pub const MAX_FACE_VERTICES: usize = 16;

/// Faces of a hull whose vertices lie within this distance of one plane are one polygon, m. Too small: manifolds of one
/// triangle, on which stacks creep. Too large: contacts beside the surface.
pub const COPLANAR_DISTANCE: f32 = LINEAR_SLOP;

/// The same as a share of the hull's radius, for hulls of millimetres: the smaller of the two holds.
pub const COPLANAR_SHARE: f32 = 2e-3;

/// Smallest cosine between two triangles that may share a face polygon (about 2.6°).
pub const COPLANAR_COSINE: f32 = 0.999;

/// Smallest principal moment of inertia, as a share of the largest: a needle would spin without bound in f32.
pub const MIN_INERTIA_RATIO: f32 = 1e-3;

/// Largest principal moment of inertia over the smallest above which a body counts as slender (a box of 4 : 1 : 1): its
/// spin is carried over in its own frame.
pub const SLENDER_INERTIA_RATIO: f32 = 8.0;

/// Spin, before or after a substep, from which a slender body that touches nothing fixed is turned as its momentum asks
/// even where it touches something free, rad/s. Slower ones stay where their contacts have them: what lies in a bowl
/// would creep.
pub const HIT_SPIN: f32 = 1.0;

/// Largest distance to which the contact margin of two bodies grows with their speeds, m: they see their contacts a
/// substep ahead, each up to 30 m/s.
pub const MAX_SPECULATIVE_MARGIN: f32 = 0.5;

/// Half extent of the box of a body without hulls, m: it overlaps nothing.
pub const NO_EXTENT: f32 = -1e30;

/// Contact points nearer to each other than this are one, m.
pub const SAME_POINT: f32 = 1e-3;

/// The same of points on which a body rests, m: a thin rod lies on a facet no wider, and with one point for both its
/// edges it would roll off.
pub const SAME_RESTING_POINT: f32 = 3e-4;

/// How many metres of reach a metre of height above the deepest point costs when the points on which a body rests are
/// chosen: they are those that would be lowest if it leaned by 5 mrad. A bump of 0.5 mm is felt up to 10 cm inside an
/// outline.
pub const RESTING_PENALTY: f32 = 200.0;

/// Height above the deepest point that costs nothing, m: whatever bears is chosen by its place alone, and the choice
/// does not flicker.
pub const BEARING_HEIGHT: f32 = LINEAR_SLOP;

/// The same as `RESTING_PENALTY` when the points onto which a body may roll are chosen: lowest at a lean of 11°, by
/// which a ball of 5 cm turns in a substep at 1.2 m/s. Without them a ball of many corners sinks in between those that
/// it rests on and those that it may land on, and is braked.
pub const ROLLING_PENALTY: f32 = 5.0;

/// The same when the points on which a body may land are chosen: lowest at a lean of 45°. Without them a thin plate
/// that falls on a corner swings through what it falls on.
pub const LANDING_PENALTY: f32 = 1.0;

/// What is no deeper than this below a face glides over it, m: what rests is up to a slop deep.
pub const GLIDING_DEPTH: f32 = 2.0 * LINEAR_SLOP;

/// Largest cosine between that face and the contact that does not act because of it: another contact bears what glides.
pub const GLIDING_COSINE: f32 = 0.5;

/// Patches kept per body pair. With fewer than six or so, a cone slips through the ring that holds it.
pub const MAX_PATCHES: usize = 8;

/// Smallest cosine between the normals of one patch (about 15°).
pub const PATCH_COSINE: f32 = 0.966;

/// Smallest cosine between the normal of a patch and a point that joins it because there are no more patches (45°).
pub const JOINING_COSINE: f32 = 0.707;

/// Contact points gathered per body pair before they are merged; the list is merged whenever it is full.
pub const MAX_GATHERED_POINTS: usize = 128;

/// A body that moved by no more than this since its contacts were found keeps those with others that did not, m; they
/// follow the bodies to first order (Box3D's idea). Below `BEARING_HEIGHT`, so that the points on which it rests are
/// the same.
pub const RECYCLING_DISTANCE: f32 = 0.5 * LINEAR_SLOP;

/// An old contact point hands its impulse to a new one within this distance on either body, m.
pub const MATCH_DISTANCE: f32 = 0.01;

/// Smallest cosine between the normals of matching contact points.
pub const MATCH_COSINE: f32 = 0.9;

/// Natural frequency of a contact's spring, Hz. Stiffer separates overlap faster; too stiff shakes stacks of bodies
/// with many contact points.
pub const CONTACT_FREQUENCY: f32 = 120.0;

/// Upper limit of that frequency as a share of the solver's rate, beyond which the spring is not resolved.
pub const CONTACT_FREQUENCY_SHARE: f32 = 1.0 / 6.0;

/// Damping ratio of that spring; far above 1, so that overlap creeps apart without overshoot (in a twelfth of a
/// second), and so that towers do not sway. Above about 35 push-out leaves energy in bodies that tumble.
pub const CONTACT_DAMPING_RATIO: f32 = 30.0;

/// How much faster what is deeper than `TOUCHING_DEPTH` is pushed out, as a share of the rest a second, 1/s. The spring
/// alone would take seconds to part a heap of things that begin inside one another.
pub const DEEP_PUSH_OUT_RATE: f32 = 24.0;

/// How fast the springs of a patch take over the load that the patch carries, 1/s. Slower leaves heavy things sagging
/// for longer; faster loses the springs' damping, and heavy things on light ones bounce.
pub const PATCH_LOAD_RATE: f32 = 4.0;

/// How fast the spring of a point takes over its own share of that load, 1/s. This is the integral part of what rights
/// a leaning tower, the spring being the proportional part: too fast and tall stacks sway and fall, too slow and a load
/// beside the middle sinks on its side for seconds.
pub const POINT_LOAD_RATE: f32 = 0.5;

/// Share of its load that a spring does not take over for every metre of depth, 1/m: nothing from 8 mm on. Things that
/// jam each other would else take over each other's push without bound, and fly apart when one of them slips.
pub const LOAD_LOSS: f32 = 125.0;

/// Smallest cosine between the vertical and the normal of a patch whose lower body bears the upper one when the first
/// loads are found (60°).
pub const BEARING_COSINE: f32 = 0.5;

/// Most sweeps that find the first loads, without friction and again with it. A pile of thirty books takes forty.
pub const MAX_LOAD_SWEEPS: u32 = 64;

/// They end when none of them changed the acceleration of a contact by more than this, as a share of gravity.
pub const LOAD_TOLERANCE: f32 = 2e-3;

/// Largest overlap at which bodies rest, m. Those that meet with less rest where they met, until they are pressed
/// further together than by so much: with room to sink into each other before they bear, what leans on each other would
/// hand its load to friction elsewhere and be left without any; without more of it under heavy things, these would
/// sway.
pub const RESTING_DEPTH: f32 = 0.5 * LINEAR_SLOP;

/// Least overlap at which they rest, m: without it contacts would come and go.
pub const LEAST_RESTING_DEPTH: f32 = 0.05 * LINEAR_SLOP;

/// How fast faces on faces sink to `RESTING_DEPTH`, m/s: a spring that is at rest deeper pulls both ways over a longer
/// way, and light tables under several heavy things rattle without it. Edges do not, for things lean on edges.
pub const RESTING_RATE: f32 = 2e-5;

/// Most contact points of an edge; what has more is a face.
pub const MAX_EDGE_POINTS: usize = 2;

/// Fewest sweeps of a small step over the contacts as springs: every other one backwards, because sweeps in one
/// direction leave an error that goes round and round, and crossed blocks rattle for ever. With one, stacks and what
/// lies in a drawer rattle.
pub const MIN_PUSHING_SWEEPS: u32 = 2;

/// Most of them. With eight, a light table under several heavy things throws them off.
pub const MAX_PUSHING_SWEEPS: u32 = 12;

/// Friction is solved before the first so many of them: to do it before all takes longer and brings nothing. With two,
/// heavy things that overhang light ones sag by one to two millimetres more.
pub const MAX_FRICTION_SWEEPS: u32 = 3;

/// Sweeps of the springs end when none of them changed the speed of a contact by more than this, m/s. Larger leaves
/// energy in heaps and lets light tables walk. What is deeper than `TOUCHING_DEPTH` is only pushed out, and does not
/// count: push-out that all sweeps agree on adds up.
pub const PUSHED_SPEED: f32 = 2e-3;

/// Rigid sweeps of a small step end when none of their contacts changed its speed by more than this, m/s: things at
/// rest get by with one. Larger leaves the speed of push-out in things that hit each other, and heavy things near the
/// edge of light ones fall.
pub const RELAXED_SPEED: f32 = 0.02;

/// Most rigid sweeps of a small step. Twice as many leave a fifth to three fifths less energy in stacks with light
/// bottoms, and cost 5 to 7 % of the speed.
pub const MAX_RELAXING_SWEEPS: u32 = 16;

/// Rigid sweeps after the first take so many times the impulse by which a contact is off above `HIT_SPEED` (successive
/// over-relaxation): heavy things on light ones are stopped in fewer sweeps, each of which passes on a share of the hit
/// that is the smaller the heavier they are.
pub const OVER_RELAXATION: f32 = 1.8;

/// What a contact is off above this is a hit, m/s. Below, over-relaxation keeps light tables under heavy things
/// rattling.
pub const HIT_SPEED: f32 = 0.1;

/// A small step that leaves a candidate more than so many times the kinetic energy that it would have without contacts
/// is solved again without a first guess.
pub const ENERGY_GAIN: f32 = 1.001;

/// What speed of all bodies, m/s, is allowed beyond that: sweeps leave some, and more of it where overlap is pushed
/// out.
pub const LEFT_SPEED: f32 = 0.05;

/// Two bodies that have moved past each other by more than this get new lever arms at their contacts, m: too much turns
/// bodies that collide.
pub const ARM_TOLERANCE: f32 = 1e-6;

/// A body that has turned by more than this since gets new ones, too, rad; what is slender, about its length.
pub const TURN_TOLERANCE: f32 = 1e-3;

/// How many times its first size a candidate's slots may grow before the candidate is given up.
pub const MAX_CAPACITY_GROWTH: u32 = 64;

/// Most faces of a hull of `MAX_HULL_VERTICES` (Euler: 2 V − 4).
pub const MAX_HULL_FACES: usize = 2 * MAX_HULL_VERTICES - 4;

/// Most edges of a hull of `MAX_HULL_VERTICES` (Euler: 3 V − 6).
pub const MAX_HULL_EDGES: usize = 3 * MAX_HULL_VERTICES - 6;

/// Most contact points of one hull pair, of a hull and the ground, and of one patch of a body pair. Fewer is faster;
/// too few cut corners off a support polygon, and things tip that stand.
pub const MAX_MANIFOLD_POINTS: usize = 8;

/// By how much a face of the smaller hull must beat the best face of the larger, and an edge pair the best face, to
/// become the contact's axis, m. Axes of nearly equal depth would otherwise alternate from step to step, and the
/// manifold with them.
pub const AXIS_BIAS: f32 = 0.5 * LINEAR_SLOP;

/// The same as a share of the depth: deep overlaps of boxes have edge axes that differ from a face by less than this.
pub const AXIS_BIAS_RELATIVE: f32 = 0.01;

/// What rounding may add to a height over a face, m: no edge is ruled out by less, so that it does not matter in whose
/// frame the height was found. Well below `AXIS_BIAS`, or the edges around a face that touches would be searched.
pub const AXIS_ROUNDING: f32 = 0.1 * LINEAR_SLOP;

/// Most times that the way out of something fixed and along the ground is longer than the one into the ground: as good
/// as barred, so that what is swallowed near the ground leaves by a side instead of jamming between both.
pub const GROUND_PENALTY: f32 = 1e3;

/// The ground counts for what would be pushed into it with more than this share of its height. What is only squeezed
/// there, or leans on something slanted, stays where it is, as it would in other engines.
pub const ROOM_SHARE: f32 = 0.5;

/// Depth up to which the last step's axis is used again without a search, m. No other axis can be better by more than
/// twice this; it must stay below `TOUCHING_DEPTH`.
pub const COHERENT_DEPTH: f32 = LINEAR_SLOP;

/// Edges at a smaller sine than this have no usable common normal in f32; their axis is within a slop of a face's.
pub const PARALLEL_SINE: f32 = 1e-4;

/// A face whose normal is within this cosine of the contact normal (3.6°) is clipped against; below it a contact is one
/// point.
pub const ALIGNED_COSINE: f32 = 0.998;

/// By how much (as a cosine) a face of the smaller hull must be better aligned than the larger's to become the
/// reference face (about 0.3°).
pub const ALIGNED_BIAS: f32 = 1e-5;

/// All faces of the incident hull within this cosine (8°) of the reference face are clipped: a bottom of several nearly
/// coplanar facets rests on all of them.
pub const INCIDENT_COSINE: f32 = 0.99;

/// How far beside a side plane a clipped point still counts as inside, m: corners over corners stay themselves.
pub const CLIP_TOLERANCE: f32 = 0.1 * LINEAR_SLOP;

/// Most lines of an outline; a face of `MAX_FACE_VERTICES` with its flat neighbours seldom has more than twice as many.
pub const MAX_LINES: usize = 2 * MAX_FACE_VERTICES;

/// A convex polygon gains at most one corner from each line that cuts it.
pub const MAX_CLIPPED: usize = MAX_FACE_VERTICES + MAX_LINES;

/// Contact points of a hull pair collected before they are reduced.
pub const MAX_COLLECTED: usize = MAX_CLIPPED + MAX_MANIFOLD_POINTS;

/// How far a body of the self-test may end from where the processor has it, m + rad, beside what a nudge of the start
/// makes on the processor. Drivers round differently, and half a second of contacts makes that some micrometres, of
/// what tumbles more; a wrong kernel makes centimetres.
pub const SELF_TEST_DISTANCE: f32 = 1e-3;

/// That nudge, m: some ten rounding errors of a position.
pub const SELF_TEST_NUDGE: f32 = 1e-6;

/// How far the energies of the self-test's search may be off, as a share.
pub const SELF_TEST_ENERGY: f32 = 0.05;
