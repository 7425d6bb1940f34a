// The sensors' supply through a session: what the file says of it.
#include "session_rig.h"

TEST(changes_of_the_supply_are_in_the_file_between_its_scans) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble && rig.session.supply_mv == 3300);
    rig.run(100);
    fake::reference_code = 346;  // 3252 mV: too small a change
    rig.run(100);
    fake::reference_code = 347;  // 3242 mV
    rig.run(100);
    CHECK(rig.session.supply_mv == 3242 && rig.session.tally.lowest_mv == 3242);
    fake::reference_code = 335;  // 3359 mV
    rig.run(43);
    fake::reference_code = 0;  // nonsense
    rig.run(100);
    fake::reference_code = 341;
    rig.run(22);  // the session ends before a block for it could be written
    CHECK(rig.stop() == kNoTrouble);
    const Found found = decode("HOP00001.HOP");
    CHECK(found.kinds == "HVVVS" && found.scans == 465 && found.lost == 0);
    CHECK(found.supply ==
          "supply_mv=3242\nscan=208\nsupply_mv=3359\nscan=304\nsupply_mv=3300\nscan=464\n");
    CHECK(rig.session.tally.lowest_mv == 3242);
}

TEST(of_several_changes_the_lowest_is_told_and_nothing_waits_in_a_busy_cards_memory) {
    if (!insert_card()) return;
    Rig rig;
    CHECK(rig.session.start() == kNoTrouble);
    fake::reference_code = 400;  // 2813 mV
    rig.run(10);
    fake::card.busy_us = 700000;
    rig.run(28);
    fake::card.busy_us = 0;
    rig.run(12);
    fake::reference_code = 450;  // 2500 mV, while the card is still busy
    rig.run(32);
    fake::reference_code = 341;
    rig.run(100);
    CHECK(rig.stop() == kNoTrouble);
    const Found found = decode("HOP00001.HOP");
    CHECK(found.lost == 0 && found.scans == 182);
    CHECK(found.supply == "supply_mv=2500\nscan=80\nsupply_mv=3300\nscan=112\n");
}
