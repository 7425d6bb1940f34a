#pragma once
#include <stdint.h>

// An SD or SDHC card on SPI. Nothing here waits for a card that is busy or starts: poll() asks it
// once and returns.
//
//     Down ── begin() ──> Starting ── poll() … ──> Ready ── write() ──> Busy ── poll() … ──> Ready
//
// From every state a card that does not answer leads to Down, and so does one that contradicts
// itself while it starts. Commands and data carry CRCs, and the card's status is asked for after
// every write.
class SdCard {
  public:
    enum State : uint8_t { Down, Starting, Ready, Busy };

    void begin();  // wake the card, whatever it was doing
    void poll();
    State state() const { return state_; }

    // In state Ready: hand 512 bytes to the card. True: the card has taken them and `data` may be
    // reused. Either way the card is Busy now, and afterwards written() tells whether they are
    // safe.
    bool write(uint32_t sector, const void* data);
    bool written() const { return written_; }

    // In state Ready: read 512 bytes, at once; with nullptr they are checked and not kept.
    bool read(uint32_t sector, void* data);

    // Poll until Ready or Down. finish() is for a card that is not Starting: FatFs's deepest calls
    // end there, and RAM is short.
    bool settle();
    bool finish();
    bool present();  // Ready, and still the card that was woken

    bool write_protected() const { return protected_; }
    uint16_t id() const {
        return id_;
    }  // CRC of the card's identification: another card, another id

    // Two sectors, none of them 0, by which the card is known again: begin() forgets that it was
    // changed() and compares their contents before the card is Ready. False: it cannot be read.
    bool watch(uint8_t which, uint32_t sector);
    void forget() { watched_[0].sector = changed_ = 0; }
    bool changed() const { return changed_; }

    uint16_t longest_busy_ms = 0;

  private:
    uint8_t command(uint8_t index, uint32_t argument);
    uint8_t application_command(uint8_t index, uint32_t argument);
    uint16_t status();
    bool wait_for(uint8_t token);
    bool receive(void* data, uint16_t size);
    bool receive_data(void* data, uint16_t size);
    void start() __attribute__((noinline));
    void ask_if_busy();
    bool ask_for_traits();
    bool take_sheet();
    bool ask_for_sheet(uint8_t index, uint32_t argument);
    void check_write();
    void deselect();
    uint32_t address(uint32_t sector) const { return (traits_ & kBySector) ? sector : sector << 9; }
    uint16_t elapsed() const;
    void fall() { state_ = Down; }

    // What is asked for next while Starting. Before the sheets the card's answers are short.
    enum Step : uint8_t { Reset, PowerUp, Traits, SpecificData, Identification, Watched };

    static const uint8_t kVersion2 = 1;
    static const uint8_t kBySector = 2;  // SDHC: addresses count sectors, not bytes
    static const uint8_t kChecks = 4;    // CRCs are on
    static const uint8_t kKnown = 8;     // known_traits_ are some card's

    struct Sector {
        uint32_t sector;  // 0: none
        uint16_t crc;
    };
    Sector watched_[2] = {};
    uint16_t crc_ = 0;       // of the data that were read last
    uint16_t since_ms_ = 0;  // when Starting or Busy began, or a sheet was asked for
    uint16_t id_ = 0;
    State state_ = Down;
    uint8_t step_ = Reset;      // the second sector's is behind Watched
    uint8_t traits_ = 0;        // of the card in the socket
    uint8_t known_traits_ = 0;  // of the card with this id; 0: none was identified yet
    bool accepted_ = false;
    bool written_ = false;
    bool protected_ = false;
    bool changed_ = false;
};

extern SdCard card;
