// What the roles of roscpp_bench.cpp measure and wait with, and their options. The same as in measuring.py.
#pragma once
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "roscpp_payloads.hpp"

static const double kSettle = 0.3;  // seconds after the first message before counting begins
static const int kBurst = 50;       // small messages between two looks at the clock
static const double kPause = 50e-6; // after each image: without it the publisher replaces what waits before it can be sent
static const double kIdle = 5;

struct Options {
  std::map<std::string, std::string> given;
  std::string text(const std::string& key, const std::string& otherwise = "") const {
    auto found = given.find(key);
    return found == given.end() ? otherwise : found->second;
  }
  double number(const std::string& key, double otherwise) const {
    return given.count(key) ? std::stod(given.at(key)) : otherwise;
  }
  int queue() const { return number("queue", 1000); }
  double seconds() const { return number("seconds", 5); }
  size_t size() const { return number("size", 0); }
  int count() const { return number("count", 0); }
};

inline double now() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec + t.tv_nsec * 1e-9;
}

inline void wait(double seconds) { ros::WallDuration(seconds).sleep(); }

inline double cpuSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_utime.tv_sec + usage.ru_stime.tv_sec + (usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
}

// What this process takes of the processor, from now on.
struct Cpu {
  double start = now(), used = cpuSeconds();
  double percent() const { return (cpuSeconds() - used) / (now() - start) * 100; }
};

// A number of /proc/self/status; sizes are in kB.
inline double status(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.compare(0, key.size() + 1, key + ":") == 0) return std::stod(line.substr(key.size() + 1));
  return 0;
}

// The value in microseconds that this part of the times does not exceed.
inline double share(std::vector<double>& times, double part) {
  if (times.empty()) return NAN;
  std::sort(times.begin(), times.end());
  return times[times.size() * part] * 1e6;
}

inline void ready() {
  std::puts("ready");
  std::fflush(stdout);
}

inline void handleCallbacks(double seconds) {
  ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(seconds));
}

// Handles callbacks for so long.
inline void handleFor(double seconds) {
  for (const double end = now() + seconds; ros::ok() && now() < end;) handleCallbacks(0.05);
}

// Handles callbacks until something has been counted, and kSettle longer.
template <class C> void handleFirst(const C& count) {
  while (ros::ok() && count() == 0) handleCallbacks(0.05);
  handleFor(kSettle);
}

inline void awaitSubscribers(const ros::Publisher& publisher, uint32_t count) {
  while (ros::ok() && publisher.getNumSubscribers() < count) wait(0.01);
}

inline void awaitPublisher(const ros::Subscriber& subscriber) {
  while (ros::ok() && subscriber.getNumPublishers() == 0) wait(0.01);
}

template <class M, class F> ros::Subscriber subscribe(ros::NodeHandle& node, const std::string& topic, int queue, F heard) {
  return node.subscribe<M>(topic, queue, boost::function<void(const boost::shared_ptr<M const>&)>(heard), ros::VoidConstPtr(),
                           ros::TransportHints().tcpNoDelay());
}

template <class M> M filled(size_t size) {
  M message;
  fill(message, size);
  return message;
}

// Calls publish(count) for so long, as fast as it goes; returns calls per second.
template <class F> double tightLoop(double seconds, bool large, F publish) {
  long count = 0;
  const double start = now();
  while (ros::ok() && now() - start < seconds) {
    for (int i = 0; i < (large ? 1 : kBurst); ++i) publish(count++);
    if (large) wait(kPause);
  }
  return count / (now() - start);
}

// Calls publish() at a frequency in Hz: until all has settled, for so many seconds, of which it returns the percentage of
// a processor that this process took, and one more second.
template <class F> double steadyLoop(double frequency, double seconds, F publish) {
  ros::Rate rate(frequency);
  const auto go = [&](double span) {
    for (const double end = now() + span; ros::ok() && now() < end; rate.sleep()) publish();
  };
  go(kSettle);
  const Cpu cpu;
  go(seconds);
  const double percent = cpu.percent();
  go(1);
  return percent;
}
