#include "check.h"
#include "ring.h"

namespace {

const uint8_t kScanSize = 13;
const int kCapacity = 486 / kScanSize;

struct Rig {
    Block blocks[2];
    Ring ring{blocks[0], blocks[1]};
    uint32_t next = 0, stored = 0;

    explicit Rig(uint8_t scan_size = kScanSize) { ring.begin(scan_size); }

    void add(int count) {
        for (; count; --count, ++next) {
            uint8_t scan[kScanSize] = {static_cast<uint8_t>(next), static_cast<uint8_t>(next >> 8)};
            ring.add(next, scan, 0);
        }
    }

    // The card takes the waiting block; its place in the scans must be what its header says.
    void take() {
        Block* block = ring.waiting();
        CHECK(block != nullptr);
        if (!block) return;
        CHECK(block->first_scan == stored + block->lost);
        for (int k = 0; k < block->count; ++k) {
            CHECK(block->payload[k * kScanSize] == static_cast<uint8_t>(block->first_scan + k));
        }
        stored += block->count;
        ring.release();
    }
};

}  // namespace

TEST(a_full_block_waits_at_once) {
    Rig rig;
    rig.add(kCapacity - 1);
    CHECK(!rig.ring.waiting());
    rig.add(1);
    CHECK(rig.ring.waiting() && rig.ring.waiting()->count == kCapacity);
}

TEST(two_blocks_fill_before_anything_is_lost) {
    Rig rig;
    rig.add(2 * kCapacity);
    CHECK(rig.ring.lost() == 0 && rig.ring.depth() == 2 * kCapacity);
    rig.add(5);
    CHECK(rig.ring.lost() == 5 && rig.ring.deepest() == 2 * kCapacity);
    rig.take();
    rig.add(1);
    rig.take();
    CHECK(rig.ring.lost() == 5);
    rig.ring.finish(rig.next);
    rig.take();
    CHECK(rig.stored + rig.ring.lost() == rig.next);
}

TEST(skipped_numbers_begin_a_new_block_and_count_as_lost) {
    Rig rig;
    rig.add(3);
    rig.next += 4;
    rig.add(2);
    CHECK(rig.ring.lost() == 4);
    rig.take();
    rig.ring.finish(rig.next + 1);  // one more was due at the end
    rig.take();
    CHECK(rig.stored + rig.ring.lost() == rig.next + 1);
    CHECK(rig.ring.due() == rig.next + 1);  // so the summary says
}

TEST(scans_behind_a_gap_wait_for_a_block_of_their_own) {
    Rig rig;
    rig.add(kCapacity + 5);  // one block waits, the other is partly full
    rig.next += 4;
    rig.add(3);  // there is no block for these
    CHECK(rig.ring.lost() == 7 && rig.ring.depth() == kCapacity + 5);
    rig.take();
    rig.add(2);
    rig.take();
    rig.ring.finish(rig.next);
    rig.take();
    CHECK(rig.ring.lost() == 7 && rig.stored + rig.ring.lost() == rig.next);
}

TEST(an_inserted_block_goes_first_and_keeps_the_count) {
    Rig rig;
    rig.add(kCapacity);
    rig.take();
    rig.next += 2;
    rig.add(3);
    Block& block = rig.ring.insert('V');
    CHECK(block.kind == 'V' && rig.ring.waiting() == &block && rig.ring.depth() == 3);
    CHECK(block.first_scan == static_cast<uint32_t>(kCapacity) + 2 && block.lost == 2);
    rig.add(kCapacity - 3);  // the block behind it is full, and stays until it has gone
    rig.take();
    CHECK(rig.ring.waiting() && rig.ring.waiting()->kind == 'D');
    rig.take();
    CHECK(rig.ring.insert('V').first_scan == rig.next && rig.ring.depth() == 0);
    rig.take();
    rig.add(1);
    rig.ring.finish(rig.next);
    rig.take();
    CHECK(rig.ring.lost() == 2 && rig.stored + rig.ring.lost() == rig.next);
}

TEST(a_block_that_failed_after_release_is_charged_to_all_that_follow) {
    Rig rig;
    rig.add(2 * kCapacity + 3 - 3);
    rig.ring.release();
    rig.ring.lose(kCapacity);  // it never reached the card
    rig.add(3);
    rig.take();
    rig.ring.finish(rig.next);
    rig.take();
    CHECK(rig.ring.lost() == kCapacity && rig.stored + rig.ring.lost() == rig.next);
}

TEST(a_new_session_counts_from_zero) {
    Rig rig;
    rig.next = 5;
    rig.add(2 * kCapacity + 3);
    rig.ring.begin(kScanSize);
    CHECK(rig.ring.due() == 0 && rig.ring.lost() == 0);
    CHECK(rig.ring.depth() == 0 && rig.ring.deepest() == 0 && !rig.ring.waiting());
    rig.next = 0;
    rig.add(kCapacity);
    rig.take();
    CHECK(rig.ring.lost() == 0 && rig.ring.deepest() == kCapacity);
}

TEST(what_is_abandoned_is_lost) {
    Rig rig;
    rig.add(kCapacity + 9);
    rig.ring.abandon();
    CHECK(rig.ring.lost() == kCapacity + 9 && rig.ring.depth() == 0 && !rig.ring.waiting());
}

TEST(numbers_may_pass_sixteen_and_thirty_two_bits) {
    Rig rig;
    rig.add(70000 % kCapacity);
    rig.ring.finish(rig.next);
    rig.take();
    rig.next = 0xFFFFFFFE;
    const uint32_t lost = rig.ring.lost();
    rig.add(1);
    CHECK(rig.ring.lost() - lost == 0xFFFFFFFE - 70000 % kCapacity);
    rig.add(3);  // 0xFFFFFFFF, 0, 1
    CHECK(rig.ring.lost() - lost == 0xFFFFFFFE - 70000 % kCapacity);
}

TEST(small_scans_still_fit_the_counters) {
    Rig rig(2);
    rig.add(1000);
    CHECK(rig.ring.room() == 254 && rig.ring.deepest() == 254 && rig.ring.lost() == 1000 - 254);
}
