//! From a mesh to convex parts, mass, centre of mass and inertia.
