// Runs the compiled circuit cycle by cycle: drives its pins from lists, keeps what its pins do.
// A cycle is named by the counter during it. An input that changes during cycle n has its new level at the clock edge
// that begins cycle n + 1; an output counts as changed in the first cycle in which it has its new level.
#include <cstdint>
#include <vector>

#include "circuit.cc"

namespace {

using Circuit = cxxrtl_design::p_trigger__generator;

constexpr int data_bits = 8;

// A byte on its way into the circuit: start bit, data, stop bit.
struct Sender {
  int64_t next_change = -1;
  int bits_left = 0;
  unsigned rest = 0;
};

// A byte on its way out, sampled in the middle of each bit.
struct Receiver {
  int64_t start = 0, next_sample = -1;
  int bits = 0;
  unsigned byte = 0;
};

struct Bench {
  Circuit circuit;
  int64_t cycle = 0, bit_cycles;
  unsigned inputs = 0, outputs = 0;
  bool tx = true;
  Sender sender;
  Receiver receiver;
  std::vector<int64_t> tx_cycles, output_cycles;
  std::vector<uint8_t> tx_bytes, output_levels;
  int64_t framing_errors = 0;

  explicit Bench(int64_t bit_cycles) : bit_cycles(bit_cycles) { circuit.p_rx.set<bool>(true); }

  void set_input(int pin, bool level) {
    inputs = (inputs & ~(1u << pin)) | (unsigned(level) << pin);
    circuit.p_camera__in.set<bool>(inputs & 1);
    circuit.p_control__in.set<bool>(inputs >> 1 & 1);
    circuit.p_application__in.set<bool>(inputs >> 2 & 1);
    circuit.p_spare__in.set<bool>(inputs >> 3 & 1);
  }

  void begin_byte(uint8_t byte) {
    circuit.p_rx.set<bool>(false);
    sender = {cycle + bit_cycles, data_bits + 1, byte | 1u << data_bits};
  }

  void next_bit() {
    circuit.p_rx.set<bool>(sender.rest & 1);
    sender.rest >>= 1;
    sender.next_change = --sender.bits_left ? cycle + bit_cycles : -1;
  }

  // The rising edge that ends the cycle; the falling one changes nothing. One evaluation takes the outputs from the
  // registers as they are before the edge: they are those of the cycle that ends.
  void clock_edge() {
    circuit.prev_p_clk.set<bool>(false);
    circuit.p_clk.set<bool>(true);
    circuit.step();
    watch_line();
    watch_outputs();
    ++cycle;
  }

  void watch_line() {
    const bool level = circuit.p_tx.get<bool>();
    if (receiver.next_sample < 0) {
      if (tx && !level) receiver = {cycle, cycle + bit_cycles / 2 + bit_cycles, 0, 0};
    } else if (cycle == receiver.next_sample) {
      if (receiver.bits < data_bits) {
        receiver.byte |= unsigned(level) << receiver.bits++;
        receiver.next_sample += bit_cycles;
      } else {
        if (level) {
          tx_cycles.push_back(receiver.start);
          tx_bytes.push_back(uint8_t(receiver.byte));
        } else {
          ++framing_errors;
        }
        receiver.next_sample = -1;
      }
    }
    tx = level;
  }

  void watch_outputs() {
    const unsigned now = circuit.p_chopper__out.get<bool>() | unsigned(circuit.p_camera__out.get<bool>()) << 1;
    if (now == outputs) return;
    outputs = now;
    output_cycles.push_back(cycle);
    output_levels.push_back(uint8_t(now));
  }
};

}  // namespace

extern "C" {

Bench *bench_new(int64_t bit_cycles) { return new Bench(bit_cycles); }

void bench_delete(Bench *bench) { delete bench; }

// Runs until the counter is `until`. Lists rise in their cycles. Byte i begins in rx_cycles[i], after the one before it
// has ended. Input pins are numbered as in set_input.
void bench_run(Bench *bench, int64_t until, int64_t n_inputs, const int64_t *input_cycles, const uint8_t *input_pins,
               const uint8_t *input_levels, int64_t n_rx, const int64_t *rx_cycles, const uint8_t *rx_bytes) {
  Bench &b = *bench;
  b.tx_cycles.clear();
  b.tx_bytes.clear();
  b.output_cycles.clear();
  b.output_levels.clear();
  for (int64_t input = 0, rx = 0; b.cycle < until;) {
    for (; input < n_inputs && input_cycles[input] == b.cycle; ++input) b.set_input(input_pins[input], input_levels[input]);
    if (b.sender.next_change == b.cycle) b.next_bit();
    if (rx < n_rx && rx_cycles[rx] == b.cycle) b.begin_byte(rx_bytes[rx++]);
    b.clock_edge();
  }
}

int64_t bench_cycle(const Bench *bench) { return bench->cycle; }
int64_t bench_framing_errors(const Bench *bench) { return bench->framing_errors; }
int64_t bench_tx_count(const Bench *bench) { return int64_t(bench->tx_bytes.size()); }
const int64_t *bench_tx_cycles(const Bench *bench) { return bench->tx_cycles.data(); }
const uint8_t *bench_tx_bytes(const Bench *bench) { return bench->tx_bytes.data(); }
int64_t bench_output_count(const Bench *bench) { return int64_t(bench->output_levels.size()); }
const int64_t *bench_output_cycles(const Bench *bench) { return bench->output_cycles.data(); }
const uint8_t *bench_output_levels(const Bench *bench) { return bench->output_levels.data(); }
}
