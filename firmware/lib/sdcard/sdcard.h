#pragma once
#include <stdint.h>

// An SD or SDHC card on SPI. Nothing here waits for a busy card: poll() asks it once and returns.
//
//     Down ── begin() ──> Starting ── poll() … ──> Ready ── write() ──> Busy ── poll() … ──> Ready
//
// From every state a card that does not answer leads to Down. Commands and data carry CRCs, and the
// card's status is asked for after every write.
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

    // In state Ready: read 512 bytes, at once.
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

    uint16_t longest_busy_ms = 0;

  private:
    uint8_t command(uint8_t index, uint32_t argument);
    uint8_t application_command(uint8_t index, uint32_t argument);
    uint16_t status();
    bool wait_for(uint8_t token);
    bool receive(void* data, uint16_t size);
    void start() __attribute__((noinline));
    void ask_if_busy();
    void identify();
    void check_write();
    void deselect();
    uint32_t address(uint32_t sector) const { return by_sector_ ? sector : sector << 9; }
    uint16_t elapsed() const;
    void fall() { state_ = Down; }

    uint16_t since_ms_ = 0;  // when Starting or Busy began
    uint16_t id_ = 0;
    State state_ = Down;
    bool awake_ = false;  // CMD0 was answered
    bool version_2_ = false;
    bool by_sector_ = false;  // SDHC: addresses count sectors, not bytes
    bool checks_ = false;     // CRCs are on
    bool accepted_ = false;
    bool written_ = false;
    bool protected_ = false;
};

extern SdCard card;
