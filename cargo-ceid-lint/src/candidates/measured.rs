//! Which types hold what is measured: floats, vectors of them, generic numbers; and which hold counts.

use super::words::{is_among, is_asked_for_more};
use crate::index::{Index, Shape, Ty, TypeId};

/// Whether values of the type are measured, not counted: floats, vectors of them, generic numbers.
pub(super) fn is_measured(index: &Index, ty: &Ty, depth: u32) -> bool {
    if depth > 4 {
        return false;
    }
    match ty {
        Ty::Float => true,
        Ty::Param(param) => param.bounds.iter().all(|bound| {
            let name = index.trait_text(&bound.name);
            !name.starts_with("Fn") && !is_asked_for_more(&name)
        }),
        Ty::Ref(_, inner) | Ty::Array(inner, _) | Ty::Slice(inner) => is_measured(index, inner, depth + 1),
        Ty::Tuple(parts) => parts.iter().any(|part| is_measured(index, part, depth + 1)),
        Ty::External(path, args) => {
            let name = path.rsplit("::").next().unwrap_or(path);
            is_vector(name) || (is_container(name) && args.iter().any(|arg| is_measured(index, arg, depth + 1)))
        }
        Ty::Adt(id, _) => {
            let name = &index.type_def(*id).name;
            is_vector(name) || is_plain_number_type(index, *id, depth)
        }
        _ => false,
    }
}

/// Whether a type of the analysed code is a value made of measured numbers: all its fields are.
fn is_plain_number_type(index: &Index, id: TypeId, depth: u32) -> bool {
    let def = index.type_def(id);
    let Shape::Struct(fields) = &def.shape else { return false };
    let ty = Ty::Adt(id, vec![Ty::Unknown; def.generics.params.len()]);
    let is_number = |name: &str| index.field_ty(&ty, None, name).is_some_and(|ty| is_measured(index, &ty, depth + 1));
    !fields.fields.is_empty() && fields.fields.len() <= 6 && fields.fields.iter().all(|field| is_number(&field.name))
}

fn is_container(name: &str) -> bool {
    matches!(
        name,
        "Vec"
            | "VecDeque"
            | "Option"
            | "Deque"
            | "HistoryBuffer"
            | "ArrayVec"
            | "Box"
            | "Wrapping"
            | "Cell"
            | "RefCell"
            | "CircularBuffer"
            | "ConstGenericRingBuffer"
            | "AllocRingBuffer"
            | "Circular"
            | "Bounded"
            | "Fixed"
            | "SmallVec"
            | "ArrayDeque"
            | "Ring"
    )
}

/// Whether values of the type are points in time: when something was last seen is kept by whatever has states, and no sample is
/// computed into it.
pub(super) fn is_point_in_time(index: &Index, ty: &Ty) -> bool {
    let name = match ty.peel() {
        Ty::External(path, args) => match (path.rsplit("::").next().unwrap_or(path), args.as_slice()) {
            ("Option", [inner]) => return is_point_in_time(index, inner),
            (name, _) => name,
        },
        Ty::Adt(id, _) => index.type_def(*id).name.as_str(),
        _ => return false,
    };
    matches!(name, "Time" | "Instant" | "SystemTime" | "DateTime" | "Timestamp")
}

fn is_vector(name: &str) -> bool {
    const VECTORS: &str = "\
    Vector Matrix Quat Rotation Isometry Translation Point Complex Fixed Vec2 Vec3 Vec4 Mat2 Mat3 Mat4 DVec \
    DQuat Affine Transform Angle Length Velocity Acceleration Frequency Ratio Torque Orientation AtomicF32 \
    AtomicF64 Euler Quaternion";
    const EXACT: &str = "\
    f32x4 f32x2 f64x2 f32x8 I16F16 I32F32 SVector SMatrix OVector OMatrix UnitQuaternion UnitVector3 \
    Current Q31 Q15 F32x4 Frame Real";
    is_among(EXACT, name) || VECTORS.split(' ').any(|vector| name.starts_with(vector) || name.ends_with(vector))
}

/// Whether values of the type are counts or states: whole numbers and truth values.
pub(super) fn is_counted(ty: &Ty) -> bool {
    match ty {
        Ty::Int | Ty::Bool => true,
        Ty::Array(inner, _) | Ty::Slice(inner) => is_counted(inner),
        _ => false,
    }
}
