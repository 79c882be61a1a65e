//! Assembly of elastic energy, forces, stiffness and mass over the elements: shape functions, quadrature, reference
//! geometry, tangent kinds and nodal rotations.

pub(crate) mod elastic;
pub(crate) mod kernels;
pub(crate) mod mass;
pub(crate) mod quadrature;
pub(crate) mod reference;
pub(crate) mod rotation;
pub(crate) mod shape_functions;
