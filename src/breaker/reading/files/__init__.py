"""Files of instruments: which of them is which operation, and the columns of numbers in them.

Finds the records of a folder, by its table of operations or by names that leave no doubt. Reads
texts, workbooks, COMTRADE and labelled arrays as the settings say, or says file, line and reason.
"""
