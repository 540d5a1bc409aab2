// As `cpu::contacts::Contact::excess`.

#import constants
#import contact

// What a contact carries beyond its load, as far as it can be one: less the deeper it is. N s a small step.
fn excess(contact: Contact) -> f32 {
    let share = max(1.0 + LOAD_LOSS * min(contact.separation, 0.0), 0.0);
    return share * contact.impulse - contact.load;
}
