#include "check.h"
#include "ring.h"

namespace {

const uint8_t kScanSize = 13;
const int kCapacity = 486 / kScanSize;

template <uint8_t kBlocks>
struct Rig {
    Block blocks[kBlocks];
    RingOf<kBlocks> ring{blocks[0], blocks[1], blocks + 2};
    uint32_t next = 0, stored = 0;
    uint16_t late = 0;

    explicit Rig(uint8_t scan_size = kScanSize) { ring.begin(scan_size); }

    void add(int count) {
        for (; count; --count, ++next) {
            uint8_t scan[kScanSize] = {static_cast<uint8_t>(next), static_cast<uint8_t>(next >> 8)};
            ring.add(next, scan, late);
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

    // The session is over: all that is left goes to the card.
    void finish() {
        for (int k = 0; k <= kBlocks; ++k) {
            ring.finish(next);
            if (ring.waiting()) take();
        }
        CHECK(!ring.waiting() && !ring.depth());
        CHECK(stored + ring.lost() == next && ring.due() == next);
    }
};

}  // namespace

// Of the Nano's ring and of the Mega's.
#define TEST_RINGS(name)                             \
    template <uint8_t kBlocks>                       \
    static void name();                              \
    static Test name##_of_2(#name "_of_2", name<2>); \
    static Test name##_of_8(#name "_of_8", name<8>); \
    template <uint8_t kBlocks>                       \
    static void name()

TEST_RINGS(a_full_block_waits_at_once) {
    Rig<kBlocks> rig;
    rig.add(kCapacity - 1);
    CHECK(!rig.ring.waiting());
    rig.add(1);
    CHECK(rig.ring.waiting() && rig.ring.waiting()->count == kCapacity);
    CHECK(rig.ring.waiting()->kind == 'D' && rig.ring.depth() == kCapacity);
}

TEST_RINGS(all_blocks_fill_before_anything_is_lost) {
    Rig<kBlocks> rig;
    rig.add(kBlocks * kCapacity);
    CHECK(rig.ring.lost() == 0 && rig.ring.depth() == kBlocks * kCapacity);
    CHECK(rig.ring.room() == kBlocks * kCapacity);
    rig.add(5);
    CHECK(rig.ring.lost() == 5 && rig.ring.deepest() == kBlocks * kCapacity);
    rig.take();
    rig.add(1);
    CHECK(rig.ring.lost() == 5);
    rig.finish();
}

TEST_RINGS(a_card_that_keeps_up_loses_nothing) {
    Rig<kBlocks> rig;
    for (int block = 0; block < 40; ++block) {
        rig.add(kCapacity);
        rig.take();
    }
    CHECK(rig.ring.lost() == 0 && rig.ring.deepest() == kCapacity);
    rig.finish();
}

TEST_RINGS(skipped_numbers_begin_a_new_block_and_count_as_lost) {
    Rig<kBlocks> rig;
    rig.add(3);
    rig.next += 4;
    rig.add(2);
    CHECK(rig.ring.lost() == 4);
    rig.take();
    ++rig.next;  // one more was due at the end
    rig.finish();
    CHECK(rig.ring.lost() == 5);
}

TEST_RINGS(scans_behind_a_gap_wait_for_a_block_of_their_own) {
    Rig<kBlocks> rig;
    rig.add((kBlocks - 1) * kCapacity + 5);  // all but one wait, the last is partly full
    rig.next += 4;
    rig.add(3);  // there is no block for these
    CHECK(rig.ring.lost() == 7 && rig.ring.depth() == (kBlocks - 1) * kCapacity + 5);
    rig.take();
    rig.add(2);
    rig.finish();
    CHECK(rig.ring.lost() == 7);
}

TEST_RINGS(an_inserted_block_goes_first_and_keeps_the_count) {
    Rig<kBlocks> rig;
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
    rig.finish();
    CHECK(rig.ring.lost() == 2);
}

TEST_RINGS(a_block_that_failed_after_release_is_charged_to_all_that_follow) {
    Rig<kBlocks> rig;
    rig.add(kBlocks * kCapacity);
    rig.ring.release();
    rig.ring.lose(kCapacity);  // it never reached the card
    rig.add(3);
    rig.finish();
    CHECK(rig.ring.lost() == kCapacity);
}

// What is said of late triggers belongs to the block's last scan, in a block without scans to the
// one before it.
TEST_RINGS(a_block_tells_the_late_triggers_up_to_its_last_scan) {
    Rig<kBlocks> rig;
    rig.add(2);
    rig.late = 7;
    rig.add(kCapacity - 2);
    CHECK(rig.ring.waiting() && rig.ring.waiting()->late == 7);
    rig.take();
    CHECK(rig.ring.insert('V').late == 7);
}

TEST_RINGS(a_new_session_counts_from_zero) {
    Rig<kBlocks> rig;
    rig.next = 5;
    rig.add(kBlocks * kCapacity + 3);
    rig.ring.begin(kScanSize);
    CHECK(rig.ring.due() == 0 && rig.ring.lost() == 0);
    CHECK(rig.ring.depth() == 0 && rig.ring.deepest() == 0 && !rig.ring.waiting());
    rig.next = 0;
    rig.add(kCapacity);
    rig.take();
    CHECK(rig.ring.lost() == 0 && rig.ring.deepest() == kCapacity);
}

TEST_RINGS(what_is_abandoned_is_lost) {
    Rig<kBlocks> rig;
    rig.add(kCapacity + 9);
    rig.ring.abandon();
    CHECK(rig.ring.lost() == kCapacity + 9 && rig.ring.depth() == 0 && !rig.ring.waiting());
}

TEST_RINGS(numbers_may_pass_sixteen_and_thirty_two_bits) {
    Rig<kBlocks> rig;
    rig.add(70000 % kCapacity);
    rig.finish();
    rig.next = 0xFFFFFFFE;
    const uint32_t lost = rig.ring.lost();
    rig.add(1);
    CHECK(rig.ring.lost() - lost == 0xFFFFFFFE - 70000 % kCapacity);
    rig.add(3);  // 0xFFFFFFFF, 0, 1
    CHECK(rig.ring.lost() - lost == 0xFFFFFFFE - 70000 % kCapacity);
}

TEST_RINGS(small_scans_still_fit_the_counters) {
    Rig<kBlocks> rig(2);
    rig.add(2000);
    CHECK(rig.ring.room() == kBlocks * 127 && rig.ring.deepest() == rig.ring.room());
    CHECK(rig.ring.lost() == 2000u - rig.ring.room());
}
