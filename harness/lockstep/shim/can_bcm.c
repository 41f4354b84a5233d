// The broadcast manager: cyclic frames, and notices only of frames that change or fail to come, as in
// Documentation/networking/can.rst of the kernel. Multiplex filters are not supported.
#include "can.h"
#include <stddef.h>

struct operation {
    struct virtual_timer timer;
    struct operation *next;
    struct can_socket *owner;
    bool is_receiver, has_frame;
    int interface;
    struct bcm_msg_head head;
    struct canfd_frame *frames, last;
    uint32_t index, left;
};

static int64_t span_of(const struct bcm_timeval *span) { return span->tv_sec * SECOND + span->tv_usec * 1000; }

static size_t stride(const struct bcm_msg_head *head) { return head->flags & CAN_FD_FRAME ? CANFD_MTU : CAN_MTU; }

static void tell(struct operation *of, uint32_t opcode, const struct canfd_frame *frame) {
    char message[sizeof of->head + CANFD_MTU];
    size_t size = frame ? stride(&of->head) : 0;
    struct bcm_msg_head head = of->head;
    head.opcode = opcode;
    head.nframes = frame ? 1 : 0;
    memcpy(message, &head, sizeof head);
    if (frame) memcpy(message + sizeof head, frame, size);
    can_put(of->owner, message, sizeof head + size);
}

static void transmit_next(struct operation *of) {
    if (of->head.nframes == 0) return;
    can_transmit(of->owner, of->interface, &of->frames[of->index]);
    of->index = (of->index + 1) % of->head.nframes;
}

// The first `count` frames use the first interval, all others the second.
static void set_next(struct operation *of) {
    int64_t first = span_of(&of->head.ival1), then = span_of(&of->head.ival2);
    int64_t interval = of->left > 0 && first > 0 ? first : then;
    timer_set(&of->timer, interval > 0 ? deadline_after(interval) : NEVER, 0);
}

static void fire_transmit(struct virtual_timer *timer, uint64_t count) {
    struct operation *of = (struct operation *)timer;
    (void)count;
    transmit_next(of);
    if (of->left > 0 && --of->left == 0 && (of->head.flags & TX_COUNTEVT)) tell(of, TX_EXPIRED, NULL);
    set_next(of);
}

static void fire_missing(struct virtual_timer *timer, uint64_t count) {
    struct operation *of = (struct operation *)timer;
    (void)count;
    of->has_frame = false;
    tell(of, RX_TIMEOUT, NULL);
}

static struct operation *find(struct can_socket *can, bool is_receiver, int interface, canid_t id, uint32_t flags) {
    for (struct operation *of = can->operations; of; of = of->next)
        if (of->is_receiver == is_receiver && of->head.can_id == id && of->interface == interface
            && ((of->head.flags ^ flags) & CAN_FD_FRAME) == 0)
            return of;
    return NULL;
}

static struct operation *find_or_make(struct can_socket *can, bool is_receiver, int interface,
                                      const struct bcm_msg_head *head) {
    struct operation *of = find(can, is_receiver, interface, head->can_id, head->flags);
    if (of || !(of = calloc(1, sizeof *of))) return of;
    of->owner = can;
    of->is_receiver = is_receiver;
    of->interface = interface;
    of->timer.fire = is_receiver ? fire_missing : fire_transmit;
    timer_add(&of->timer);
    of->next = can->operations;
    return can->operations = of;
}

static struct canfd_frame frame_of(const struct bcm_msg_head *head, const void *data) {
    struct canfd_frame frame = {0};
    memcpy(&frame, data, stride(head));
    frame.flags = head->flags & CAN_FD_FRAME ? frame.flags | CANFD_FDF : 0;
    return frame;
}

static bool take_frames(struct operation *of, const struct bcm_msg_head *head, const void *frames) {
    struct canfd_frame *copy = calloc(head->nframes + 1, sizeof *copy);
    if (!copy) return false;
    for (uint32_t i = 0; i < head->nframes; i++) {
        copy[i] = frame_of(head, (const char *)frames + i * stride(head));
        if (head->flags & TX_CP_CAN_ID) copy[i].can_id = head->can_id;
    }
    if (of->head.nframes != head->nframes || (head->flags & TX_RESET_MULTI_IDX)) of->index = 0;
    free(of->frames);
    of->frames = copy;
    return true;
}

static int set_transmit(struct can_socket *can, int interface, const struct bcm_msg_head *head, const void *frames) {
    if (!can_name(interface)) return errno = ENODEV, -1;
    if (head->nframes < 1 || head->nframes > 256) return errno = EINVAL, -1;
    struct operation *of = find_or_make(can, false, interface, head);
    if (!of || !take_frames(of, head, frames)) return errno = ENOMEM, -1;
    struct bcm_msg_head before = of->head;
    of->head = *head;
    if (head->flags & SETTIMER) {
        of->left = head->count;
    } else {
        of->head.ival1 = before.ival1, of->head.ival2 = before.ival2, of->head.count = before.count;
    }
    bool starts = head->flags & STARTTIMER;
    if (starts || (head->flags & TX_ANNOUNCE)) {
        transmit_next(of);
        if (of->left > 0 && span_of(&of->head.ival1) > 0) of->left--;
    }
    bool is_timed = span_of(&of->head.ival1) > 0 || span_of(&of->head.ival2) > 0;
    if (starts || ((head->flags & SETTIMER) && !is_timed)) set_next(of);
    return 0;
}

static int set_receive(struct can_socket *can, int interface, const struct bcm_msg_head *head, const void *frames) {
    if (head->nframes > 1 || (head->flags & RX_RTR_FRAME)) return errno = EOPNOTSUPP, -1;
    struct operation *of = find_or_make(can, true, interface, head);
    if (!of || !take_frames(of, head, frames)) return errno = ENOMEM, -1;
    of->head = *head;
    of->has_frame = false;
    timer_set(&of->timer, NEVER, 0);
    int64_t span = span_of(&head->ival1);
    if ((head->flags & STARTTIMER) && span > 0) timer_set(&of->timer, deadline_after(span), 0);
    return 0;
}

static void drop(struct operation *of) {
    struct operation **place = &of->owner->operations;
    while (*place != of) place = &(*place)->next;
    *place = of->next;
    timer_remove(&of->timer);
    free(of->frames);
    free(of);
}

static int remove_or_read(struct can_socket *can, bool is_receiver, bool is_removed, int interface,
                          const struct bcm_msg_head *head) {
    struct operation *of = find(can, is_receiver, interface, head->can_id, head->flags);
    if (!of) return errno = EINVAL, -1;
    if (is_removed) drop(of);
    else tell(of, is_receiver ? RX_STATUS : TX_STATUS, of->frames);
    return 0;
}

// Handles what a program writes to the manager.
ssize_t bcm_take(struct can_socket *can, int interface, const void *data, size_t size) {
    struct bcm_msg_head head;
    if (!can->is_bound) return errno = ENOTCONN, -1;
    if (size < sizeof head) return errno = EINVAL, -1;
    memcpy(&head, data, sizeof head);
    const char *frames = (const char *)data + sizeof head;
    size_t each = stride(&head);
    // The kernel counts frames only where it reads them: python-can's TX_DELETE announces one that does not follow.
    bool has_frames = head.opcode == TX_SETUP || head.opcode == RX_SETUP || head.opcode == TX_SEND;
    if ((size - sizeof head) % each) return errno = EINVAL, -1;
    if (has_frames && (size - sizeof head) / each < head.nframes) return errno = EINVAL, -1;
    int result;
    switch (head.opcode) {
    case TX_SETUP: result = set_transmit(can, interface, &head, frames); break;
    case RX_SETUP: result = set_receive(can, interface, &head, frames); break;
    case TX_DELETE:
    case TX_READ: result = remove_or_read(can, false, head.opcode == TX_DELETE, interface, &head); break;
    case RX_DELETE:
    case RX_READ: result = remove_or_read(can, true, head.opcode == RX_DELETE, interface, &head); break;
    case TX_SEND: {
        if (head.nframes != 1) return errno = EINVAL, -1;
        struct canfd_frame frame = frame_of(&head, frames);
        result = can_transmit(can, interface, &frame);
        break;
    }
    default: result = -1, errno = EINVAL;
    }
    return result ? -1 : (ssize_t)size;
}

static bool has_changed(const struct operation *of, const struct canfd_frame *frame) {
    if (!of->has_frame) return true;
    if ((of->head.flags & RX_CHECK_DLC) && of->last.len != frame->len) return true;
    // The mask of a filter selects the bits to compare; without a mask all bits count, with RX_FILTER_ID none.
    if (of->head.flags & RX_FILTER_ID) return true;
    for (int i = 0; i < CANFD_MAX_DLEN; i++) {
        uint8_t mask = of->head.nframes ? of->frames[0].data[i] : 0xff;
        if ((of->last.data[i] ^ frame->data[i]) & mask) return true;
    }
    return false;
}

void bcm_hear(struct can_socket *can, int interface, const struct canfd_frame *frame) {
    for (struct operation *of = can->operations; of; of = of->next) {
        if (!of->is_receiver || of->head.can_id != frame->can_id || stride(&of->head) != frame_size(frame)) continue;
        if (of->interface && of->interface != interface) continue;
        bool is_told = has_changed(of, frame);
        of->last = *frame;
        of->has_frame = true;
        if (is_told) tell(of, RX_CHANGED, frame);
        int64_t span = span_of(&of->head.ival1);
        if (span > 0) timer_set(&of->timer, deadline_after(span), 0);
    }
}

void bcm_release(struct can_socket *can) {
    while (can->operations) drop(can->operations);
}
