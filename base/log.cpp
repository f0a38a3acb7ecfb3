// SPDX-License-Identifier: Apache-2.0
#include "base/log.hpp"

#include <spdlog/async_logger.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdlib>
#include <future>
#include <optional>
#include <thread>
#include <utility>

#include "base/text.hpp"

namespace lcrig {

namespace {

// sd-daemon(3): a line that starts with <N> has syslog priority N.
class PriorityFlag final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& msg, const std::tm&,
              spdlog::memory_buf_t& dest) override {
    static constexpr std::string_view kPriority[] = {"<7>", "<7>", "<6>", "<4>", "<3>", "<2>", ""};
    const auto text = kPriority[static_cast<std::size_t>(msg.level)];
    dest.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return spdlog::details::make_unique<PriorityFlag>();
  }
};

// Escapes each message, because it may quote an operator's note or an instrument's reply. This
// prevents forged log lines and terminal escape codes.
class HarmlessMessage final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& msg, const std::tm&,
              spdlog::memory_buf_t& dest) override {
    constexpr std::size_t kMost = 4000;
    const std::string text = printable({msg.payload.data(), msg.payload.size()}, kMost);
    dest.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return spdlog::details::make_unique<HarmlessMessage>();
  }
};

constexpr std::size_t kMostWaiting = 1000;  // messages
constexpr std::chrono::seconds kPatienceAtTheEnd{2};

// Sits between the log thread and the real sinks, and reports how many messages the full queue
// dropped. Only the thread of `pool` calls it; `pool` outlives it.
class Counting final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  Counting(std::vector<spdlog::sink_ptr> sinks, spdlog::details::thread_pool& pool)
      : sinks_(std::move(sinks)), pool_(pool) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& msg) override {
    const std::size_t lost = pool_.overrun_counter();
    if (lost > told_) {
      const std::string text =
          fmt::format("{} messages were left out here: nobody took them", lost - told_);
      told_ = lost;
      write(spdlog::details::log_msg(msg.logger_name, spdlog::level::warn, text));
    }
    write(msg);
  }
  void flush_() override {
    for (const auto& to : sinks_) to->flush();
  }

 private:
  void write(const spdlog::details::log_msg& msg) {
    for (const auto& to : sinks_) to->log(msg);
  }

  std::vector<spdlog::sink_ptr> sinks_;
  spdlog::details::thread_pool& pool_;
  std::size_t told_ = 0;
};

std::optional<spdlog::level::level_enum> level_of(std::string_view word) {
  const auto level = spdlog::level::from_str(std::string(word));
  if (level == spdlog::level::off && word != "off") return std::nullopt;
  return level;
}

}  // namespace

LogThread::LogThread()
    : direct_(spdlog::default_logger()),
      pool_(std::make_shared<spdlog::details::thread_pool>(kMostWaiting, 1)) {
  auto logger = std::make_shared<spdlog::async_logger>(
      direct_->name(), std::make_shared<Counting>(direct_->sinks(), *pool_), pool_,
      spdlog::async_overflow_policy::overrun_oldest);
  logger->set_level(direct_->level());
  logger->flush_on(direct_->flush_level());
  spdlog::set_default_logger(std::move(logger));
}

// The pool's destructor waits for the sink, which may never return. Another thread runs it, and
// this one waits with a limit.
LogThread::~LogThread() {
  const auto level = direct_->level();
  direct_->set_level(spdlog::level::off);
  spdlog::set_default_logger(direct_);
  std::promise<void> written;
  auto is_written = written.get_future();
  std::thread end([pool = std::move(pool_), done = std::move(written)]() mutable {
    pool.reset();
    done.set_value();
  });
  if (is_written.wait_for(kPatienceAtTheEnd) != std::future_status::ready) {
    end.detach();
    return;
  }
  end.join();
  direct_->set_level(level);
}

std::unique_ptr<spdlog::formatter> log_formatter(bool journal) {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PriorityFlag>('*');
  formatter->add_flag<HarmlessMessage>('&');
  formatter->set_pattern(journal ? "%*%&" : "%H:%M:%S.%e %l: %&");
  return formatter;
}

bool set_log_level(std::string_view level) {
  const auto wanted = level_of(level);
  if (wanted) spdlog::default_logger()->set_level(*wanted);
  return wanted.has_value();
}

bool set_up_logging(std::string_view level) {
  const auto wanted = level_of(level);
  if (!wanted) return false;
  auto logger =
      std::make_shared<spdlog::logger>("lcrig", std::make_shared<spdlog::sinks::stderr_sink_mt>());
  logger->set_formatter(log_formatter(std::getenv("JOURNAL_STREAM") != nullptr));
  logger->set_level(*wanted);
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
  return true;
}

}  // namespace lcrig
