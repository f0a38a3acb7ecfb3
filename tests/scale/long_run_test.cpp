// SPDX-License-Identifier: Apache-2.0
// A run of ten million rows: nothing is lost, memory does not grow, and the results are right.
#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <string_view>
#include <thread>

#include "analysis/analysis.hpp"
#include "analysis/export.hpp"
#include "tests/support/long_run.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/support/temp_dir.hpp"

#if LCRIG_SANITIZED
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();  // g++ 12 ships no header of it
#endif

namespace lcrig {
namespace {

constexpr std::int64_t kRows = 10'000'000;
constexpr std::size_t kMegabyte = 1'000'000;

// Bytes of heap that the program holds now. Resident memory is no measure, because the sanitizer
// keeps freed memory for a while.
std::size_t heap_bytes() {
#if LCRIG_SANITIZED
  return __sanitizer_get_current_allocated_bytes();
#else
  const struct mallinfo2 m = ::mallinfo2();
  return m.uordblks + m.hblkhd;
#endif
}

// Takes lines as they come out of a pipe, and looks at the heap now and then.
class Lines {
 public:
  using Look = std::function<void(std::int64_t number, std::string_view line)>;  // number from 0

  explicit Lines(Look look) : look_(std::move(look)), before_(heap_bytes()) {
    if (::pipe(pipe_.data()) != 0) throw std::runtime_error("pipe");
    reader_ = std::jthread([this] { read(); });
  }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;
  ~Lines() { finish(); }
  int fd() const { return pipe_[1]; }
  void finish() {
    if (!reader_.joinable()) return;
    ::close(pipe_[1]);
    reader_.join();
    ::close(pipe_[0]);
  }
  std::int64_t count() const { return count_; }
  std::size_t bytes() const { return bytes_; }
  std::size_t most_held() const { return most_ > before_ ? most_ - before_ : 0; }
  bool ended_with_a_line() const { return rest_.empty(); }

 private:
  void read() {
    std::string buffer(1 << 16, '\0');
    for (;;) {
      const ssize_t n = ::read(pipe_[0], buffer.data(), buffer.size());
      if (n <= 0) return;
      most_ = std::max(most_, heap_bytes());
      bytes_ += static_cast<std::size_t>(n);
      take(std::string_view(buffer.data(), static_cast<std::size_t>(n)));
    }
  }
  void take(std::string_view text) {
    for (auto end = text.find('\n'); end != text.npos; end = text.find('\n')) {
      const std::string_view line = text.substr(0, end);
      look_(count_++, rest_.empty() ? line : rest_ += line);
      rest_.clear();
      text.remove_prefix(end + 1);
    }
    rest_ += text;
  }

  Look look_;
  std::array<int, 2> pipe_{};
  std::jthread reader_;
  std::string rest_;
  std::int64_t count_ = 0;
  std::size_t bytes_ = 0, before_ = 0, most_ = 0;
};

// Force and capacitance of an aligned line: columns 8 and 10.
std::array<double, 2> numbers_of(std::string_view line) {
  std::array<double, 2> out{};
  for (int column = 1; column <= 10; ++column) {
    const auto comma = std::min(line.find(','), line.size());
    if (column == 8) std::from_chars(line.data(), line.data() + comma, out[0]);
    if (column == 10) std::from_chars(line.data(), line.data() + comma, out[1]);
    line.remove_prefix(std::min(comma + 1, line.size()));
  }
  return out;
}

class LongRunTest : public testing::Test {
 protected:
  void SetUp() override {
    auto db = open_read_write(dir_.file("long.db"));
    ASSERT_TRUE(db) << db.error().what;
    db_ = std::move(*db);
  }
  void export_to(Lines& lines, std::int64_t run, Layout layout) {
    const auto r = export_layout(db_, run, layout, lines.fd(), "pipe");
    lines.finish();
    EXPECT_TRUE(r) << r.error().what;
    EXPECT_TRUE(lines.ended_with_a_line());
  }
  // Checks every line by its number, and many by every digit. Returns the first mistake.
  std::string wrong_in_frame(const LongRun& truth, std::int64_t run, std::size_t& held) {
    std::string wrong;
    Lines lines([&](std::int64_t number, std::string_view line) {
      if (number == 0 || !wrong.empty()) return;
      const std::int64_t i = number - 1;
      std::int64_t seq = 0;
      const auto end = std::from_chars(line.data(), line.data() + line.size(), seq);
      const bool whole = i < 3 || i >= truth.samples - 3 || i * 2654435761 % 4096 == 0;
      if (seq != number || *end.ptr != ',' || (whole && line != LongRun::frame_line(i) + '\r')) {
        wrong = fmt::format("{} instead of {}", line, LongRun::frame_line(i));
      }
    });
    export_to(lines, run, Layout::frame);
    EXPECT_EQ(lines.count(), truth.samples + 1);
    held = lines.most_held();
    return wrong;
  }

  void expect_alignment(const LongRun& truth, std::int64_t run) {
    double force_error = 0, capacitance_error = 0;
    Lines lines([&](std::int64_t number, std::string_view line) {
      if (number == 0) return;
      const std::int64_t j = number - 1;
      const auto [pF, force] = numbers_of(line);
      const double true_force = static_cast<double>(LongRun::force_at_uN(j)) * 1e-6;
      force_error = std::max(force_error, std::abs(force - true_force));
      const double true_pF = static_cast<double>(LongRun::capacitance_aF(j)) * 1e-6;
      capacitance_error = std::max(capacitance_error, std::abs(pF - true_pF));
    });
    export_to(lines, run, Layout::aligned);
    EXPECT_EQ(lines.count(), truth.readings + 1);
    EXPECT_LT(force_error, 1e-9);
    EXPECT_LT(capacitance_error, 1e-14);
  }
  // Checks the errors that half a million readings with 5.8 fF of scatter should give.
  void expect_results(std::int64_t run) {
    const auto a = analyse(db_, run);
    ASSERT_TRUE(a) << a.error().what;
    EXPECT_EQ(a->cycles.size(), 4750U);
    const double N_per_kPa = LongRun::kArea_m2 * 1e3;
    EXPECT_NEAR(a->ranges[0].sensitivity.value() / (LongRun::kLow_fF_N * N_per_kPa), 1, 5e-4);
    EXPECT_NEAR(a->ranges[1].sensitivity.value() / (LongRun::kHigh_fF_N * N_per_kPa), 1, 5e-4);
    EXPECT_NEAR(a->c0.value(), LongRun::kC0_pF, 2e-3) << "of the second before contact";
    EXPECT_NEAR(a->dynamic_range.value(), LongRun::kPeak_fF / 36.5, 0.02);
    fmt::print(
        "slopes {} {}, C0 {}, dynamic range {}\n", a->ranges[0].sensitivity.value() / N_per_kPa,
        a->ranges[1].sensitivity.value() / N_per_kPa, a->c0.value(), a->dynamic_range.value());
  }

  TempDir dir_;
  Database db_;
};

// One test, because it takes a third of a minute to store the run.
TEST_F(LongRunTest, IsExportedToTheLastDigitAndAnalysedAsItWasMade) {
  const LongRun tenth(kRows / 10), whole(kRows);
  ASSERT_EQ(whole.samples + whole.readings, kRows);
  const std::int64_t first = tenth.store(db_), second = whole.store(db_);
  std::size_t tenth_held = 0, whole_held = 0;
  EXPECT_EQ(wrong_in_frame(tenth, first, tenth_held), "");
  EXPECT_EQ(wrong_in_frame(whole, second, whole_held), "");
  // Some pieces are in memory, more or fewer of them as the two threads keep pace (19 to 24 and 31
  // MB were seen). The whole text has 500 MB.
  EXPECT_GT(tenth_held, kMegabyte);
  EXPECT_LT(whole_held, 2 * tenth_held) << "ten times the rows";
  EXPECT_LT(whole_held, 64 * kMegabyte);
  fmt::print("held: {} of {} rows, {} of {}\n", tenth_held, kRows / 10, whole_held, kRows);
  expect_alignment(whole, second);
  expect_results(second);
}

}  // namespace
}  // namespace lcrig
