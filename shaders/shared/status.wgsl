// What went wrong in one candidate's simulation: bits as in `world::Status`.

const STATUS_HULL_PAIRS: u32 = 1u;
const STATUS_CONTACTS: u32 = 2u;
const STATUS_NOT_FINITE: u32 = 4u;
const STATUS_PASSED_OVER: u32 = 8u;

fn is_usable(status: u32) -> bool {
    return status == 0u;
}
