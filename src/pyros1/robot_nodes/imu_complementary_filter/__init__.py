"""imu_complementary_filter: estimates an IMU's orientation with a complementary filter.

See https://wiki.ros.org/imu_complementary_filter.
"""
