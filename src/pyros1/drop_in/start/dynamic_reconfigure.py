# Replaces itself with the actual module with this name: see pyros1_modules.take_over.
import pyros1_modules

pyros1_modules.take_over(__name__)
