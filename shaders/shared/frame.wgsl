// The motion that takes one body's frame into another's.

#import vector

struct Frame {
    rotation: mat3x3<f32>,
    shift: vec3<f32>,
}

// The matrix of a unit quaternion.
fn matrix(q: vec4<f32>) -> mat3x3<f32> {
    let d = q.xyz + q.xyz;
    let x = q.x * d;
    let w = q.w * d;
    let yy = q.y * d.y;
    let yz = q.y * d.z;
    let zz = q.z * d.z;
    return mat3x3(
        vec3(1.0 - (yy + zz), x.y + w.z, x.z - w.y),
        vec3(x.y - w.z, 1.0 - (x.x + zz), yz + w.x),
        vec3(x.z + w.y, yz - w.x, 1.0 - (x.x + yy)),
    );
}

// Takes points of `b`'s frame into the frame of `a`.
fn between(a: Pose, b: Pose) -> Frame {
    let back = conjugate(a.rotation);
    return Frame(matrix(compose(back, b.rotation)), rotate(back, b.translation - a.translation));
}

fn inverse(frame: Frame) -> Frame {
    return Frame(transpose(frame.rotation), -(frame.shift * frame.rotation));
}

fn carried(frame: Frame, point: vec3<f32>) -> vec3<f32> {
    return times(frame.rotation, point) + frame.shift;
}
