"""Plausible but wrong inputs, each with its right twin: is anything false told without a word?"""
